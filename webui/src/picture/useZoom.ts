// SPDX-License-Identifier: Apache-2.0
// Wheel, drag and pinch on an image's frame.
import { ref, shallowRef, type Ref } from 'vue';
import type { Size } from '../geometry/turn';
import { WHOLE, type View } from './useBox';
import { panned, zoomed } from './view';

const STEP = 1.4;
const PRIMARY = 0;
const MIDDLE = 1;
const WHEEL = 0.0016;
/** A press that moves less than this is a click on the object under it. */
const CLICK_PX = 4;

export function useZoom(frame: Ref<HTMLElement | null>, picture: () => Size) {
  const view = shallowRef<View>(WHOLE);
  const dragging = ref(false);
  const fingers = new Map<number, { x: number; y: number }>();
  let travelled = 0;

  const frameSize = (): Size => ({ width: frame.value?.clientWidth ?? 1, height: frame.value?.clientHeight ?? 1 });
  const fromMiddle = (x: number, y: number) => {
    const rect = frame.value!.getBoundingClientRect();
    return [x - rect.left - rect.width / 2, y - rect.top - rect.height / 2] as const;
  };

  const zoomBy = (factor: number, x = 0, y = 0) => { view.value = zoomed(view.value, factor, x, y, frameSize(), picture()); };
  const panBy = (dx: number, dy: number) => { view.value = panned(view.value, dx, dy, frameSize(), picture()); };

  function onWheel(event: WheelEvent): void {
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 20 : 1;
    zoomBy(Math.exp(-event.deltaY * lines * WHEEL), ...fromMiddle(event.clientX, event.clientY));
  }

  function onDown(event: PointerEvent): void {
    if (event.button !== PRIMARY && event.button !== MIDDLE) return;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    travelled = 0;
  }

  function onMove(event: PointerEvent): void {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const next = { x: event.clientX, y: event.clientY };
    const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const other = others[0];
    if (other) {
      const before = Math.hypot(last.x - other.x, last.y - other.y);
      const after = Math.hypot(next.x - other.x, next.y - other.y);
      if (before > 0) zoomBy(after / before, ...fromMiddle((next.x + other.x) / 2, (next.y + other.y) / 2));
    } else if (view.value.zoom > 1) {
      panBy(next.x - last.x, next.y - last.y);
    }
    travelled += Math.hypot(next.x - last.x, next.y - last.y);
    // Capturing only real drags lets clicks reach the robots under the pointer.
    if (travelled > CLICK_PX && !dragging.value && view.value.zoom > 1) {
      dragging.value = true;
      frame.value?.setPointerCapture(event.pointerId);
    }
    fingers.set(event.pointerId, next);
  }

  function onUp(event: PointerEvent): void {
    fingers.delete(event.pointerId);
    if (!fingers.size) dragging.value = false;
  }

  return {
    view, dragging, panBy, onWheel, onDown, onMove, onUp,
    zoomIn: () => zoomBy(STEP),
    zoomOut: () => zoomBy(1 / STEP),
    showWhole: () => { view.value = WHOLE; },
  };
}
