// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { FieldAgreement, FieldDifference } from '../../../api/types';
import { arrowOf, bandOf, squaresOf, trendPoints, worstOf } from './agreement';

const off = (x: number, off_x_mm: number, changes: Partial<FieldDifference> = {}): FieldDifference => ({ cameras: [0, 1], x, y: 0, off_x_mm, off_y_mm: 0, samples: 9, time: 100, ...changes });
const agreement = (differences: FieldDifference[]): FieldAgreement => ({ time: 100, part_mm: 500, cameras: [], heights: [], differences, trends: [] });

describe('differences between cameras', () => {
  it('fall into four bands', () => {
    expect([0, 1.99, 2, 5, 9.9, 10, 1000].map((mm) => bandOf(mm).text)).toEqual(['under 2 mm', 'under 2 mm', '2 to 5 mm', '5 to 10 mm', '5 to 10 mm', 'over 10 mm', 'over 10 mm']);
  });
  it('are shown by the worst pair of a place', () => {
    const squares = squaresOf(agreement([off(250, 1), off(250, -7, { cameras: [1, 2] }), off(750, 2, { time: -100 })]));
    expect(squares.map(({ x, mm, isOld }) => ({ x, mm, isOld }))).toEqual([{ x: 250, mm: 7, isOld: false }, { x: 750, mm: 2, isOld: true }]);
    expect(squares[0]!.pairs.map(({ cameras }) => cameras)).toEqual([[1, 2], [0, 1]]);
  });
  it('are listed from the worst', () => expect(worstOf(agreement([off(1, 1), off(2, -9), off(3, 4)]), 2).map(({ x }) => x)).toEqual([2, 3]));
  it('have a line of the last two hours', () => {
    const time = 10_000;
    const minutes = [{ time: time - 8000, off_mm: 1 }, { time: time - 3600, off_mm: 5 }, { time: time - 60, off_mm: 25 }];
    expect(trendPoints({ minutes, time, off_mm: 2 })).toBe('60.0,10.0 119.0,0.0 120.0,16.0');
  });
  it('have arrows that stay short enough', () => {
    expect(arrowOf(off(0, 3))).toEqual({ dx: 120, dy: 0 });
    expect(arrowOf(off(0, -100)).dx).toBeCloseTo(-800);
    expect(arrowOf(off(0, 0))).toEqual({ dx: 0, dy: 0 });
  });
});
