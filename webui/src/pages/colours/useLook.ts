// SPDX-License-Identifier: Apache-2.0
// Data under the pointer: raw pixels, their region, and the effect of a click. One request of each kind is sent at a
// time; of the waiting requests, only the newest is sent.
import { onUnmounted, ref, shallowRef, watch } from 'vue';
import { api, messageOf } from '../../api/client';
import { newestOnly } from '../../api/newestOnly';
import type { ColorCommand, ColorEdited, Pixels } from '../../api/types';
import { around, lookOf, type Look, type Place, type Rect } from './pixels';

/** Cells across the magnifier. */
export const LOUPE_CELLS = 17;
/** A pointer that rests this long requests the region. */
const REST_MS = 120;

export interface Area {
  pixels: Pixels;
  kind: 'region' | 'picked';
}

export function useLook(camera: number, still: () => number | null) {
  const look = shallowRef<Look | null>(null);
  const trial = shallowRef<{ text: ColorEdited; command: ColorCommand } | null>(null);
  const problem = ref('');
  /** The area whose histograms are shown. */
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
      // The magnifier reports the error.
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
  /** The data do not apply to another image. */
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
    /** Previews a command. */
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
    /** Repeats the request for the same place, because the table has changed. */
    again() { if (wanted) looks.put('look', wanted); },
  };
}
export type Looking = ReturnType<typeof useLook>;
