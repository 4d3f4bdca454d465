// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { camera, divisionB } from '../testing/samples';
import { mosaic } from './mosaic';

function at(id: number, x: number, y: number) {
  return camera({ id, calibration: { ...camera().calibration!, derived_camera_world_tx: x, derived_camera_world_ty: y } });
}
const order = (m: ReturnType<typeof mosaic>) => m.places.map((p) => p.camera);

describe('tiles lie as the field lies', () => {
  it('puts the -x camera on the left', () => {
    const m = mosaic([at(0, 2250, 20), at(1, -2250, -30)], divisionB);
    expect(order(m)).toEqual([1, 0]);
    expect(m).toMatchObject({ columns: 2, rows: 1 });
  });

  it('puts +y on top', () => {
    const m = mosaic([at(0, -2250, -1500), at(1, -2250, 1500), at(2, 2250, -1500), at(3, 2250, 1500)], divisionB);
    expect(order(m)).toEqual([1, 3, 0, 2]);
    expect(m).toMatchObject({ columns: 2, rows: 2 });
  });

  it('goes by number when a camera is not calibrated or two hang in one place', () => {
    expect(order(mosaic([at(1, -2250, 0), camera({ id: 0, calibration: null })], divisionB))).toEqual([0, 1]);
    expect(order(mosaic([at(1, 0, 0), at(0, 10, 0)], divisionB))).toEqual([0, 1]);
    expect(mosaic([], divisionB)).toMatchObject({ columns: 1, rows: 1, places: [] });
  });
});
