// SPDX-License-Identifier: Apache-2.0
// Measures how images arrive, and decides what to request.
import { computed, onScopeDispose, shallowRef, watch } from 'vue';
import { isLinkSlow, setStarved } from '../state/live';
import { adapt, EFFORTS, isStarved, LINK_START, SLOW_START } from './linkAdaptation';
import type { Shown } from './useLivePicture';

const PERIOD_MS = 1000;
/** A fresh image after a gap this long follows a freeze, a background tab or a lost camera: a new period begins. */
const GAP_MS = 700;
/** Without an image for this long, the link cannot be judged. */
const QUIET_MS = 10_000;

/** `areDue`: whether images are requested and the camera has some. */
export function useLinkAdaptation(wantedFps: () => number, areDue: () => boolean) {
  const state = shallowRef(isLinkSlow.value ? SLOW_START : LINK_START);
  let period: Shown[] = [];
  let quiet: ReturnType<typeof setTimeout> | undefined;

  function tell(starved: boolean): void {
    clearTimeout(quiet);
    setStarved(state, starved);
    // Nothing else resets this once no more images arrive.
    if (starved) quiet = setTimeout(() => setStarved(state, false), QUIET_MS);
  }

  function count(shown: Shown): void {
    const last = period.at(-1);
    if (last && shown.at - last.at > GAP_MS && shown.delayMs < (shown.at - last.at) / 2) period = [];
    period.push(shown);
    const lasted = shown.at - period[0]!.at;
    if (lasted < PERIOD_MS) return;
    const delays = period.map(({ delayMs }) => delayMs).sort((a, b) => a - b);
    const judged = { delayMs: delays[Math.floor(delays.length / 2)]!, fps: (period.length - 1) / (lasted / 1000), wantedFps: wantedFps() };
    tell(areDue() && isStarved(state.value, judged));
    state.value = adapt(state.value, judged);
    period = [shown];
  }
  watch(areDue, (are) => { if (!are) tell(false); });
  onScopeDispose(() => tell(false));
  return { count, effort: computed(() => EFFORTS[state.value.effort]!) };
}
