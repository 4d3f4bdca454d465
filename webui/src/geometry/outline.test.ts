// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { camera, divisionB } from '../testing/samples';
import { CameraModel } from './cameraModel';
import { coverage, linesPath } from './outline';
import { turnPixel } from './turn';

const model = new CameraModel(camera().calibration!);

describe('the field in an image', () => {
  it('passes through the crossing of halfway line and centre line', () => {
    const crossing = turnPixel(1, camera(), model.project(0, 0, 0)!);
    const points = linesPath(model, camera(), 1, divisionB).split(/[ML]/).slice(1).map((text) => text.split(' ').map(Number));
    expect(points.every(([x, y]) => Number.isFinite(x) && Number.isFinite(y))).toBe(true);
    const nearest = Math.min(...points.map(([x, y]) => Math.hypot(x! - crossing.x, y! - crossing.y)));
    expect(nearest).toBeLessThan(0.1);
  });

  it('covers the floor below the camera and not the far goal', () => {
    const xs = coverage(camera()).map(({ x }) => x);
    expect(Math.min(...xs)).toBeLessThan(1250);
    expect(Math.max(...xs)).toBeGreaterThan(1250);
    expect(Math.min(...xs)).toBeGreaterThan(-4500);
    expect(coverage(camera({ calibration: null }))).toEqual([]);
  });
});
