// SPDX-License-Identifier: Apache-2.0
// Adapts the images to the link: makes them smaller and coarser while they arrive late or rarely, and better again
// when possible.

export interface PictureEffort {
  /** Factor on the width that would be sharp. */
  width: number;
  /** JPEG quality. */
  quality: number;
}

/** From the best image to the smallest; each needs about 0.6 of the bytes of the previous one. */
export const EFFORTS: readonly PictureEffort[] = [
  { width: 1, quality: 75 },
  { width: 1, quality: 55 },
  { width: 0.75, quality: 55 },
  { width: 0.6, quality: 50 },
  { width: 0.45, quality: 45 },
  { width: 0.3, quality: 40 },
];

/** The measurements of one period. */
export interface LinkPeriod {
  /** Median delay from capture to the screen. */
  delayMs: number;
  fps: number;
  /** Requested rate, at most the camera's own. */
  wantedFps: number;
}

export interface LinkState {
  /** Index into EFFORTS. */
  effort: number;
  /** Recent minimum delay: that of the link when nothing queues. */
  floorMs: number;
  /** Good periods in a row. */
  good: number;
  /** Good periods required before better images are tried. */
  patience: number;
  /** Periods since better images were tried; late images soon after that show that the link is too slow for them. */
  sinceRaise: number;
  /** Measurements when smaller images were last chosen, and periods since. */
  lowered: { delayMs: number; fps: number; ago: number } | null;
}

export const LINK_START: LinkState = { effort: 0, floorMs: Infinity, good: 0, patience: 4, sinceRaise: Infinity, lowered: null };

const LATE_MS = 100;
const EASY_MS = 40;
/** Above this delay, the smallest image is chosen at once. */
const VERY_LATE_MS = 1000;
const SELDOM = 0.6;
const OFTEN = 0.8;
/** The floor rises by this per period, so that one lucky image or a clock change does not count forever. */
const FLOOR_RISE_MS = 1;
const FAILED_AFTER = 3;
const MOST_PATIENCE = 64;
/**
 * If smaller images help less than this, the cause is not the link but, for example, a slow computer: the next
 * reduction waits HOLD periods.
 */
const HELPED = 0.87;
const HOLD = 20;

/** On a link that is known to be slow, the first image is small: a large one would delay everything else for seconds. */
export const SLOW_START: LinkState = { ...LINK_START, effort: EFFORTS.length - 1 };

/** Whether even the smallest images arrive late or rarely. */
export const isStarved = ({ effort, floorMs }: LinkState, { delayMs, fps, wantedFps }: LinkPeriod): boolean =>
  effort === EFFORTS.length - 1 && (delayMs - floorMs > LATE_MS || fps < SELDOM * wantedFps);

/** The state after one more period. */
export function adapt(state: LinkState, { delayMs, fps, wantedFps }: LinkPeriod): LinkState {
  const floorMs = Math.min(delayMs, state.floorMs + FLOOR_RISE_MS);
  const above = delayMs - floorMs;
  const sinceRaise = state.sinceRaise + 1;
  const lowered = state.lowered && { ...state.lowered, ago: state.lowered.ago + 1 };
  if (above > LATE_MS || fps < SELDOM * wantedFps) {
    const helped = !lowered || lowered.ago > HOLD || delayMs < HELPED * lowered.delayMs || lowered.fps < HELPED * fps;
    if (!helped) return { ...state, floorMs, good: 0, sinceRaise, lowered };
    const failed = sinceRaise <= FAILED_AFTER;
    return {
      effort: above > VERY_LATE_MS ? EFFORTS.length - 1 : Math.min(state.effort + 1, EFFORTS.length - 1), floorMs, good: 0, sinceRaise: Infinity, lowered: { delayMs, fps, ago: 0 },
      patience: failed ? Math.min(state.patience * 2, MOST_PATIENCE) : state.patience,
    };
  }
  if (above > EASY_MS || fps < OFTEN * wantedFps) return { ...state, floorMs, good: 0, sinceRaise, lowered };
  const good = state.good + 1;
  if (state.effort === 0 || good < state.patience) {
    // After many good periods at the best level, the patience is reset.
    const patience = state.effort === 0 && good >= MOST_PATIENCE ? LINK_START.patience : state.patience;
    return { ...state, floorMs, good, sinceRaise, patience, lowered };
  }
  return { ...state, effort: state.effort - 1, floorMs, good: 0, sinceRaise: 0, lowered: null };
}
