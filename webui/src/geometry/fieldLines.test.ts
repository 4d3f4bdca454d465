// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB } from '../testing/samples';
import { alongLine, circle, fieldLines, fieldTitle, gridLines } from './fieldLines';

describe('field lines', () => {
  const byName = Object.fromEntries(fieldLines(divisionB).map((l) => [l.name, l]));

  it('has the league\'s lines', () => {
    expect(Object.keys(byName)).toHaveLength(12);
    expect(byName.TopTouchLine).toMatchObject({ p1: { x: -4500, y: 3000 }, p2: { x: 4500, y: 3000 } });
    expect(byName.HalfwayLine).toMatchObject({ p1: { x: 0, y: -3000 }, p2: { x: 0, y: 3000 } });
    expect(byName.LeftPenaltyStretch).toMatchObject({ p1: { x: -3500, y: -1000 }, p2: { x: -3500, y: 1000 } });
    expect(byName.RightFieldLeftPenaltyStretch).toMatchObject({ p1: { x: 4500, y: 1000 }, p2: { x: 3500, y: 1000 } });
  });

  it('cuts lines into short parts that keep their ends', () => {
    const points = alongLine(byName.TopTouchLine!, 100);
    expect(points).toHaveLength(91);
    expect(points[0]).toEqual({ x: -4500, y: 3000 });
    expect(points[90]).toEqual({ x: 4500, y: 3000 });
  });

  it('closes circles', () => {
    const points = circle({ x: 0, y: 0 }, 500, 8);
    expect(points).toHaveLength(9);
    expect(points[8]!.x).toBeCloseTo(points[0]!.x);
    expect(points[8]!.y).toBeCloseTo(points[0]!.y);
  });

  it('counts the grid from the centre', () => {
    const xs = gridLines(divisionB).filter((l) => l.name.startsWith('x')).map((l) => l.p1.x);
    expect(xs).toEqual([-4000, -3000, -2000, -1000, 0, 1000, 2000, 3000, 4000]);
  });

  it('names the division', () => {
    expect(fieldTitle(divisionB)).toBe('Division B · 9 × 6 m');
    expect(fieldTitle({ ...divisionB, field_length: 12000, field_width: 9000 })).toBe('Division A · 12 × 9 m');
    expect(fieldTitle({ ...divisionB, field_length: 4050, field_width: 2700 })).toBe('Field · 4.05 × 2.7 m');
  });
});
