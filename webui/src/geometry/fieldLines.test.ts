// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB } from '../testing/samples';
import { alongLine, arc, fieldArcs, fieldLines, fieldTitle, gridLines } from './fieldLines';

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
    const points = arc({ x: 0, y: 0 }, 500, 0, 2 * Math.PI, 8);
    expect(points).toHaveLength(9);
    expect(points[8]!.x).toBeCloseTo(points[0]!.x);
    expect(points[8]!.y).toBeCloseTo(points[0]!.y);
  });

  it('has the lines that are painted instead, where they are told', () => {
    const field = {
      ...divisionB,
      field_lines: [{ name: 'Tape', x1: 1, y1: 2, x2: 3, y2: 4 }],
      field_arcs: [{ name: 'Corner', x: 100, y: 0, radius: 50, a1: 0, a2: Math.PI / 2 }],
    };
    expect(fieldLines(field)).toEqual([{ name: 'Tape', p1: { x: 1, y: 2 }, p2: { x: 3, y: 4 } }]);
    expect(fieldArcs(field)).toHaveLength(1);
    expect(fieldArcs(field)[0]![0]).toEqual({ x: 150, y: 0 });
    expect(fieldArcs(field)[0]!.at(-1)!.y).toBeCloseTo(50);
    expect(fieldArcs(divisionB)[0]![0]).toEqual({ x: 500, y: 0 });
  });

  it('leaves out what has no size', () => {
    const bare = { ...divisionB, penalty_area_depth: 0, center_circle_radius: 0 };
    expect(fieldLines(bare)).toHaveLength(6);
    expect(fieldArcs(bare)).toEqual([]);
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
