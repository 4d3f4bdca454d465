// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB } from '../../../testing/samples';
import { angleOn, leftOf, topOf, viewOf } from './place';

const on = (view: ReturnType<typeof viewOf>, x: number, y: number) => [leftOf(view, x, y), topOf(view, x, y)].map(Math.round);

describe('the field on a canvas', () => {
  it('is as large as there is room, with +x to the right and +y up', () => {
    const view = viewOf(divisionB, 960, 800);
    expect(view).toMatchObject({ scale: 0.1, isUpright: false });
    expect(on(view, 0, 0)).toEqual([480, 400]);
    expect(on(view, 4500, 3000)).toEqual([930, 100]);
    expect(viewOf(divisionB, 960, 330).scale).toBeCloseTo(0.05);
  });

  it('stands upright where that is higher than wide: +x up, +y to the left', () => {
    const view = viewOf(divisionB, 660, 960);
    expect(view).toMatchObject({ scale: 0.1, isUpright: true });
    expect(on(view, 4500, 3000)).toEqual([30, 30]);
  });

  it('turns angles with the places', () => {
    for (const view of [viewOf(divisionB, 960, 660), viewOf(divisionB, 660, 960)]) {
      const angle = 0.7;
      const [x, y] = [leftOf(view, Math.cos(angle), Math.sin(angle)) - leftOf(view, 0, 0), topOf(view, Math.cos(angle), Math.sin(angle)) - topOf(view, 0, 0)];
      expect(Math.cos(angleOn(view, angle))).toBeCloseTo(x / view.scale);
      expect(Math.sin(angleOn(view, angle))).toBeCloseTo(y / view.scale);
    }
  });
});
