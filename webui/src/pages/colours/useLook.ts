// SPDX-License-Identifier: Apache-2.0
// What lies under the pointer: raw pixels, the region they belong to, what a click would do. Of each kind one request
// is on its way; of what is asked meanwhile only the newest is sent.
import { onUnmounted, ref, shallowRef, watch } from 'vue';
import { api, messageOf } from '../../api/client';
import { newestOnly } from '../../api/newestOnly';
import type { ColorCommand, ColorEdited, Pixels } from '../../api/types';
import { around, lookOf, type Look, type Place, type Rect } from './pixels';

/** Cells across the magnifier. */
export const LOUPE_CELLS = 17;
/** A pointer that stays this long wants to know about the region. */
const REST_MS = 120;

export interface Area {
  pixels: Pixels;
  kind: 'region' | 'picked';
}

export function useLook(camera: number, still: () => number | null) {
  const look = shallowRef<Look | null>(null);
  const trial = shallowRef<{ text: ColorEdited; command: ColorCommand } | null>(null);
  const problem = ref('');
  /** Whose histograms are shown. */
  const area = shallowRef<Area | null>(null);
  let cellPx = 1;
  let wanted: Place | null = null;
  let rest: ReturnType<typeof setTimeout> | undefined;
  let picked: Area | null = null;

  const address = (rect: Rect, region: boolean) => {
    const number = still();
    const { x, y, width, height } = rect;
    return `cameras/${camera}/pixels?x=${x}&y=${y}&width=${width}&height=${height}${region ? '&region=true' : ''}${number === null ? '' : `&still=${number}`}`;
  };
  const pixelsOf = (rect: Rect, region = false) => api.get<Pixels>(address(rect, region));

  const looks = newestOnly<Place>(async (_, place) => {
    try {
      const pixels = await pixelsOf(around(place, LOUPE_CELLS * cellPx));
      if (pixels.cell_px !== cellPx) {
        cellPx = pixels.cell_px;
        looks.put('look', place);
      }
      problem.value = '';
      if (wanted) look.value = lookOf(place, pixels);
    } catch (error) {
      problem.value = messageOf(error);
    }
  }, () => {});

  const regions = newestOnly<Place>(async (_, place) => {
    try {
      const pixels = await pixelsOf(around(place, 1), true);
      if (wanted) area.value = { pixels, kind: 'region' };
    } catch {
      // The magnifier says what is wrong.
    }
  }, () => {});

  const trials = newestOnly<ColorCommand>(async (_, command) => {
    try {
      const text = await api.tryOut<ColorEdited>(`cameras/${camera}/colors/edits`, { commands: [command], try: true });
      if (wanted) trial.value = { text, command };
    } catch {
      trial.value = null;
    }
  }, () => {});

  function leave(): void {
    wanted = null;
    clearTimeout(rest);
    look.value = null;
    trial.value = null;
    area.value = picked;
  }
  /** Of another image nothing is known any more. */
  watch(still, () => { picked = null; leave(); });
  onUnmounted(() => clearTimeout(rest));

  return {
    look, trial, area, problem,
    at(place: Place) {
      wanted = place;
      looks.put('look', place);
      clearTimeout(rest);
      rest = setTimeout(() => { if (wanted) regions.put('region', place); }, REST_MS);
    },
    /** What this would do, if it were done. */
    attempt: (command: ColorCommand) => trials.put('trial', command),
    leave,
    async pick(rect: Rect) {
      try {
        picked = { pixels: await pixelsOf(rect), kind: 'picked' };
        area.value = picked;
      } catch (error) {
        problem.value = messageOf(error);
      }
    },
    /** Asks again for the same place: the table is another one now. */
    again() { if (wanted) looks.put('look', wanted); },
  };
}
export type Looking = ReturnType<typeof useLook>;
