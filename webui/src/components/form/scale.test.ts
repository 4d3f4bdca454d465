// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { linearScale, logScale } from './scale';

describe('scales', () => {
  it('are even', () => {
    const scale = linearScale(-10, 30);
    expect([-10, 0, 30, 99].map(scale.shareOf)).toEqual([0, 0.25, 1, 1]);
    expect([0, 0.25, 1].map(scale.valueAt)).toEqual([-10, 0, 30]);
  });

  it('are logarithmic for wide ranges: a decade is a decade', () => {
    const scale = logScale(10, 1e7, false);
    expect([10, 100, 1e7, 0].map(scale.shareOf)).toEqual([0, expect.closeTo(1 / 6), 1, 0]);
    expect([0, 0.5, 1].map(scale.valueAt)).toEqual([10, 10_000, 1e7]);
  });

  it('keep to whole numbers and the limits', () => {
    const scale = logScale(3, 9999, true);
    for (let i = 0; i <= 100; i++) expect(scale.valueAt(i / 100) % 1).toBe(0);
    expect([scale.valueAt(0), scale.valueAt(1)]).toEqual([3, 9999]);
  });
});
