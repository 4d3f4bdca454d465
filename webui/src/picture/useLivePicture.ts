// SPDX-License-Identifier: Apache-2.0
// A camera's images on a canvas, each together with the detections of its own frame.
import { onUnmounted, shallowRef, watch, type Ref } from 'vue';
import type { PreviewMessage } from '../api/messages';
import type { PreviewHeader, PreviewRequest } from '../api/types';
import { ageOf, sharedLine, type PictureLine } from '../state/live';
import type { Turn } from '../geometry/turn';
import { drawTurned } from './drawTurned';

export interface Shown {
  header: PreviewHeader;
  /** As decoded, not turned; closed when the next one is shown. */
  picture: ImageBitmap;
  /** Size of the received JPEG. */
  width: number;
  height: number;
  bytes: number;
  /** Delay from capture to the screen. */
  delayMs: number;
  /** Time of display on the browser's monotonic clock. */
  at: number;
}

const same = (a: PreviewRequest | null, b: PreviewRequest | null) => JSON.stringify(a) === JSON.stringify(b);

/** `request` null: no image is requested and the last one stays (a frozen or hidden view). */
export function useLivePicture(canvas: Ref<HTMLCanvasElement | null>, request: () => PreviewRequest | null, turn: () => Turn, line: PictureLine = sharedLine) {
  const shown = shallowRef<Shown | null>(null);
  let bitmap: ImageBitmap | null = null;
  let alive = true;

  function draw(): void {
    const target = canvas.value;
    const context = target?.getContext('2d', { alpha: false });
    if (!target || !context || !bitmap) return;
    drawTurned(target, context, bitmap, turn());
  }

  function forgetPicture(): void {
    shown.value = null;
    bitmap?.close();
    bitmap = null;
    const target = canvas.value;
    target?.getContext('2d', { alpha: false })?.clearRect(0, 0, target.width, target.height);
  }

  async function onPreview({ header, jpeg }: PreviewMessage): Promise<void> {
    let next: ImageBitmap;
    try {
      next = await createImageBitmap(new Blob([jpeg], { type: 'image/jpeg' }));
    } catch {
      // A damaged image: requests the next one.
      line.acknowledge(header.camera, header.frame);
      return;
    }
    requestAnimationFrame(() => {
      // After a freeze or a change of camera, an image may still arrive.
      if (!alive || request()?.camera !== header.camera) {
        next.close();
        return;
      }
      const old = bitmap;
      bitmap = next;
      draw();
      // Vue draws the overlay before this frame is painted, so that image and vectors change together.
      shown.value = {
        header, picture: next, width: next.width, height: next.height, bytes: jpeg.length, delayMs: ageOf(header.t_capture) * 1000, at: performance.now(),
      };
      old?.close();
      // A new task runs after the paint: only then is the image on the screen.
      setTimeout(() => line.acknowledge(header.camera, header.frame));
    });
  }

  watch(request, (next, previous) => {
    if (same(next, previous ?? null)) return;
    if (previous && previous.camera !== next?.camera) line.stop(previous.camera, onPreview);
    if (next && shown.value && shown.value.header.camera !== next.camera) forgetPicture();
    if (next) line.start(next, onPreview);
  }, { immediate: true });
  watch(turn, draw);
  onUnmounted(() => {
    alive = false;
    const current = request();
    if (current) line.stop(current.camera, onPreview);
    bitmap?.close();
  });
  return { shown };
}
