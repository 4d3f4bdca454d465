// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB as field } from '../../testing/samples';
import { CameraModel } from '../../geometry/cameraModel';
import { aroundField, middles, pairOf, polygonPath, shifted, withCorner, withInserted, withoutCorner, type Polygon } from './polygon';

const square: Polygon = { points: [[0, 0], [10, 0], [10, 10], [0, 10]] };

describe('a polygon', () => {
  it('has corners that move, come and go', () => {
    expect(withCorner(square, 1, { x: 12.34, y: -3 }).points).toEqual([[0, 0], [12.3, -3], [10, 10], [0, 10]]);
    expect(withInserted(square, 3, { x: 0, y: 5 }).points).toEqual([[0, 0], [10, 0], [10, 10], [0, 10], [0, 5]]);
    const triangle = withoutCorner(square, 0);
    expect(triangle.points).toEqual([[10, 0], [10, 10], [0, 10]]);
    expect(withoutCorner(triangle, 0)).toBe(triangle);
    expect(shifted(square, 1, -2).points[0]).toEqual([1, -2]);
    expect(square.points[1]).toEqual([10, 0]);
  });

  it('has a middle on each edge', () => {
    expect(middles(square)).toEqual([{ x: 5, y: 0 }, { x: 10, y: 5 }, { x: 5, y: 10 }, { x: 0, y: 5 }]);
    expect(polygonPath({ points: square.points.slice(0, 3) })).toBe('M0.5 0.5L10.5 0.5L10.5 10.5Z');
  });

  it('stays within what the service takes', () => {
    expect(pairOf({ x: -1e9, y: 1e9 })).toEqual([-16384, 32768]);
  });

  it('lies around the field with its boundary', () => {
    const model = new CameraModel({
      focal_length: 400, principal_point_x: 390, principal_point_y: 290, distortion: 0, q0: 1, q1: 0, q2: 0, q3: 0, tx: 0, ty: 0, tz: 4000,
      pixel_image_width: 780, pixel_image_height: 580,
    });
    const around = aroundField(model, field)!;
    const a = (field.field_length / 2 + field.boundary_width) / 10;
    const b = (field.field_width / 2 + field.boundary_width) / 10;
    const xs = around.points.map(([x]) => x);
    const ys = around.points.map(([, y]) => y);
    expect([Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)]).toEqual([390 - a, 390 + a, 290 - b, 290 + b]);
  });
});
