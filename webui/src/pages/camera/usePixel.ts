// SPDX-License-Identifier: Apache-2.0
// The pixel under the pointer, or the one that was clicked or tapped.
import { computed, shallowRef, watch, type Ref } from 'vue';
import type { CameraStatus } from '../../api/types';
import { CameraModel, type Point } from '../../geometry/cameraModel';
import { unturnPixel, type Turn } from '../../geometry/turn';
import type { Rgb } from '../../picture/exposure';
import { labelOf } from '../../picture/labels';
import { toneOf, type Tone } from '../../picture/pixel';
import type { Box } from '../../picture/useBox';
import type { Shown } from '../../picture/useLivePicture';
import { now } from '../../state/live';

export interface Pixel {
  /** In the camera's image, px. */
  x: number;
  y: number;
  /** Position on the floor, mm. */
  ground: Point | null;
  rgb: Rgb;
  tone: Tone;
  /** Empty unless the labelled image is shown. */
  label: string;
}

/** A press that moves less than this is a click. */
const CLICK_PX = 6;

const one = new OffscreenCanvas(1, 1);
const context = one.getContext('2d', { willReadFrequently: true })!;

function colourAt({ picture, header }: Shown, x: number, y: number): Rgb {
  context.drawImage(picture, Math.floor((x * picture.width) / header.width), Math.floor((y * picture.height) / header.height), 1, 1, 0, 0, 1, 1);
  const [r, g, b] = context.getImageData(0, 0, 1, 1).data;
  return [r!, g!, b!];
}

export function usePixel(frame: Ref<HTMLElement | null>, box: Ref<Box | null>, shown: Ref<Shown | null>, camera: () => CameraStatus, turn: () => Turn) {
  const under = shallowRef<Point | null>(null);
  const pinned = shallowRef<Point | null>(null);
  let pressed: Point | null = null;

  function placeOf(event: MouseEvent): Point | null {
    const edge = frame.value?.getBoundingClientRect();
    if (!edge || !box.value) return null;
    const { left, top, scale } = box.value;
    const at = unturnPixel(turn(), camera(), { x: (event.clientX - edge.left - left) / scale, y: (event.clientY - edge.top - top) / scale });
    const [x, y] = [Math.round(at.x), Math.round(at.y)];
    return x >= 0 && y >= 0 && x < camera().width && y < camera().height ? { x, y } : null;
  }

  const pixel = shallowRef<Pixel | null>(null);
  const model = computed(() => {
    const { calibration } = camera();
    return calibration && new CameraModel(calibration);
  });
  function read(): void {
    const place = under.value ?? pinned.value;
    const current = shown.value;
    if (!place || !current) {
      pixel.value = null;
      return;
    }
    const rgb = colourAt(current, place.x, place.y);
    pixel.value = {
      ...place, rgb, tone: toneOf(rgb), ground: model.value?.unproject(place.x, place.y, 0) ?? null,
      label: current.header.picture === 'labels' ? labelOf(rgb) : '',
    };
  }
  // Updated with the pointer and a few times a second, not with every image: nobody reads faster.
  watch([under, pinned, now], read);

  return {
    pixel,
    /** Position of the clicked pixel in the camera's image. */
    pinned,
    onMove(event: PointerEvent) { under.value = event.pointerType === 'mouse' ? placeOf(event) : null; },
    onLeave() { under.value = null; },
    onDown(event: PointerEvent) { pressed = { x: event.clientX, y: event.clientY }; },
    onClick(event: MouseEvent) {
      const from = pressed;
      if (!from || Math.hypot(event.clientX - from.x, event.clientY - from.y) > CLICK_PX || (event.target as Element).closest('button')) return;
      const place = placeOf(event);
      const again = place && pinned.value && Math.hypot(place.x - pinned.value.x, place.y - pinned.value.y) * (box.value?.scale ?? 1) < CLICK_PX;
      pinned.value = again ? null : place;
    },
    unpin() { pinned.value = null; },
  };
}
