// SPDX-License-Identifier: Apache-2.0
// Texts about ball parameters learnt from kicks.
import type { BallLearning } from '../../api/types';

/** Titles of the published models' values. */
export const BALL_TITLES = {
  acc_slide: 'Sliding', acc_roll: 'Rolling', k_switch: 'Starts to roll',
  damping_xy_first_hop: 'First hop', damping_xy_other_hops: 'Later hops', damping_z: 'Height of hops',
} as const;

export interface LearntRow {
  key: string;
  title: string;
  learnt: string;
  now: string;
}

const unitOf = (key: string) => (key.startsWith('acc_') ? ' m/s²' : '');
/** Number of decimals that this uncertainty justifies. */
const digitsFor = (sigma: number) => Math.min(4, Math.max(0, 1 - Math.floor(Math.log10(Math.max(sigma, 1e-6)))));
const text = (value: number, digits: number) => value.toFixed(digits).replace('-', '−');

/** The values learnt so far. */
export function learntRows({ numbers }: BallLearning): LearntRow[] {
  return numbers.flatMap(({ key, learnt, sigma, now }) => {
    if (learnt === null || sigma === null) return [];
    const digits = digitsFor(sigma);
    return [{
      key,
      title: BALL_TITLES[key as keyof typeof BALL_TITLES] ?? key,
      learnt: `${text(learnt, digits)} ± ${text(sigma, digits)}${unitOf(key)}`,
      now: now === null ? '–' : `${text(now, Math.max(2, digits))}${unitOf(key)}`,
    }];
  });
}
