// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB } from '../../testing/samples';
import { dimensionsOf, MARGIN, place, planeFor, planOf } from './drawing';

const box = { width: 900, height: 600 };
const divisionA = { ...divisionB, field_length: 12000, field_width: 9000 };

describe('the field\'s drawing', () => {
  it('is to scale and leaves its margins', () => {
    const plane = planeFor([divisionB], box);
    const { edge, carpet } = planOf(divisionB, plane);
    expect(carpet.width / carpet.height).toBeCloseTo(1.5);
    expect(edge.x).toBeGreaterThanOrEqual(MARGIN.left - 1e-9);
    expect(edge.y + edge.height).toBeLessThanOrEqual(box.height - MARGIN.bottom + 1e-9);
  });

  it('shows two fields at one scale', () => {
    const plane = planeFor([divisionB, divisionA], box);
    expect(plane).toEqual(planeFor([divisionA], box));
    expect(planOf(divisionA, plane).carpet.width / planOf(divisionB, plane).carpet.width).toBeCloseTo(12 / 9);
  });

  it('measures every size where it is', () => {
    const plane = planeFor([divisionB], box);
    for (const { key, mm, from, to } of dimensionsOf(divisionB, plane)) {
      expect(Math.hypot(to.x - from.x, to.y - from.y) / plane.scale, key).toBeCloseTo(mm || divisionB.boundary_width);
    }
  });

  it('has +y above', () => {
    const plane = planeFor([divisionB], box);
    expect(place(plane, 0, 100).y).toBeLessThan(place(plane, 0, 0).y);
  });

  it('survives a box without room', () => {
    expect(planeFor([divisionB], { width: 0, height: 0 }).scale).toBe(0);
  });
});
