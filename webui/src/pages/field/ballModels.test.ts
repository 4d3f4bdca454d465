// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { hops, rollOf, speedAfter } from './ballModels';

const models = { acc_slide: -4, acc_roll: -0.5, k_switch: 0.5, damping_xy_first_hop: 0.5, damping_xy_other_hops: 0.9, damping_z: 0.5 };

describe('ball models', () => {
  it('slide, roll and stop', () => {
    // 4 m/s to 2 m/s at 4 m/s2 takes 1.5 m; 2 m/s to rest at 0.5 m/s2 takes 4 m.
    expect(rollOf(models, 4)).toEqual({ switch_m_s: 2, slide_m: 1.5, stop_m: 5.5 });
    expect(speedAfter(models, 4, 0)).toBe(4);
    expect(speedAfter(models, 4, 1.5)).toBe(2);
    expect(speedAfter(models, 4, 9)).toBe(0);
  });
  it('never stop without friction', () => {
    expect(rollOf({ ...models, acc_roll: 0 }, 4).stop_m).toBeNull();
    expect(rollOf({ ...models, acc_slide: 0 }, 4).slide_m).toBeNull();
  });
  it('hop lower each time', () => {
    expect(hops(models, 1000, 2)).toEqual([250, 62.5]);
  });
});
