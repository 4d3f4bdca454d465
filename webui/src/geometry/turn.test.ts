// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { camera } from '../testing/samples';
import { CameraModel } from './cameraModel';
import { fieldTurn, turnedSize, turnPixel, unturnPixel, type Turn } from './turn';

const size = { width: 780, height: 580 };

describe('turning images', () => {
  it('lays an image with +x up on its right side', () => {
    expect(fieldTurn(new CameraModel(camera().calibration!), size)).toBe(1);
    const opposite = { ...camera().calibration!, q0: 0.7071, q1: 0.7071, ty: -1250 };
    expect(fieldTurn(new CameraModel(opposite), size)).toBe(3);
  });

  it('leaves an uncalibrated image alone', () => {
    expect(fieldTurn(null, size)).toBe(0);
  });

  it('makes +x point right and +y up', () => {
    const model = new CameraModel(camera().calibration!);
    const turn = fieldTurn(model, size);
    const at = (x: number, y: number) => turnPixel(turn, size, model.project(x, y, 0)!);
    expect(at(1500, 0).x).toBeGreaterThan(at(1250, 0).x);
    expect(at(1250, 300).y).toBeLessThan(at(1250, 0).y);
  });

  it('keeps the corners in the corners', () => {
    for (const turn of [0, 1, 2, 3] as Turn[]) {
      const turned = turnedSize(turn, size);
      const p = turnPixel(turn, size, { x: -0.5, y: -0.5 });
      expect([0, turned.width]).toContain(p.x);
      expect([0, turned.height]).toContain(p.y);
    }
    expect(turnPixel(1, size, { x: -0.5, y: -0.5 })).toEqual({ x: 580, y: 0 });
  });

  it('finds the pixel at a place again', () => {
    for (const turn of [0, 1, 2, 3] as Turn[]) expect(unturnPixel(turn, size, turnPixel(turn, size, { x: 12, y: 345 }))).toEqual({ x: 12, y: 345 });
  });
});
