// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { learntRows } from './learntBall';

describe('what kicks tell of the ball', () => {
  it('is shown with as many digits as it is sure', () => {
    expect(learntRows({ kicks: 5, chips: 0, numbers: [
      { key: 'acc_slide', learnt: -3.412, sigma: 0.02, now: -3.4 },
      { key: 'k_switch', learnt: 0.7142, sigma: 0.0012, now: null },
    ] })).toEqual([
      { key: 'acc_slide', title: 'Sliding', learnt: '−3.412 ± 0.020 m/s²', now: '−3.400 m/s²' },
      { key: 'k_switch', title: 'Starts to roll', learnt: '0.7142 ± 0.0012', now: '–' },
    ]);
  });

  it('is nothing before it is known', () => {
    expect(learntRows({ kicks: 1, chips: 0, numbers: [{ key: 'acc_roll', learnt: null, sigma: null, now: -0.45 }] })).toEqual([]);
  });
});
