// SPDX-License-Identifier: Apache-2.0
// Watches how images come and says what to ask for.
import { computed, onScopeDispose, shallowRef, watch } from 'vue';
import { isLinkSlow, setStarved } from '../state/live';
import { adapt, EFFORTS, isStarved, LINK_START, SLOW_START } from './linkAdaptation';
import type { Shown } from './useLivePicture';

const PERIOD_MS = 1000;
/** A fresh image after a gap like this came after a freeze, a tab in the background, a lost camera: a period begins again. */
const GAP_MS = 700;
/** Without an image for this long there is nothing to judge the link by. */
const QUIET_MS = 10_000;

/** `areDue`: images are asked for and the camera has some. */
export function useLinkAdaptation(wantedFps: () => number, areDue: () => boolean) {
  const state = shallowRef(isLinkSlow.value ? SLOW_START : LINK_START);
  let period: Shown[] = [];
  let quiet: ReturnType<typeof setTimeout> | undefined;

  function tell(starved: boolean): void {
    clearTimeout(quiet);
    setStarved(state, starved);
    // Nothing else takes that back once no more images come.
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
