// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { commonAxis, placeOf, shapeOf, ticksOf } from './histogram';

const axis = { from: 1, to: 100 };

it('puts all on one axis', () => {
  expect(commonAxis([])).toBeNull();
  expect(commonAxis([{ edges_us: [], counts: [] }])).toBeNull();
  expect(commonAxis([{ edges_us: [10, 20, 40], counts: [1, 2] }, { edges_us: [], counts: [] }, { edges_us: [5, 10], counts: [3] }])).toEqual({ from: 5, to: 40 });
  expect([1, 10, 100].map((us) => placeOf(axis, us))).toEqual([0, 50, 100]);
});

it('has round ticks, and few', () => {
  expect(ticksOf({ from: 8, to: 60 })).toEqual([10, 20, 50]);
  expect(ticksOf({ from: 0.9, to: 20000 })).toEqual([1, 10, 100, 1000, 10000]);
});

it('draws bars to scale', () => {
  expect(shapeOf({ edges_us: [1, 10, 100], counts: [1, 4] }, axis)).toBe('M0 1V0.75H50V0H100V1Z');
  expect(shapeOf({ edges_us: [], counts: [] }, axis)).toBe('');
});
