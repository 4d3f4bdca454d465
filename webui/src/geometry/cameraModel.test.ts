// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Calibration } from '../api/types';
import { CameraModel, distortRadius } from './cameraModel';

const overhead: Calibration = {
  focal_length: 600, principal_point_x: 390, principal_point_y: 290, distortion: 0.1,
  q0: 0.7071, q1: -0.7071, q2: 0, q3: 0, tx: 0, ty: 1250, tz: 3500, pixel_image_width: 780, pixel_image_height: 580,
  derived_camera_world_tx: 1250, derived_camera_world_ty: 0, derived_camera_world_tz: 3500,
};

describe('camera model', () => {
  const camera = new CameraModel(overhead);

  it('stands where the league says it stands', () => {
    expect(camera.position.x).toBeCloseTo(1250, 6);
    expect(camera.position.y).toBeCloseTo(0, 6);
    expect(camera.position.z).toBeCloseTo(3500, 6);
  });

  it('sees the point below it at the principal point', () => {
    const below = camera.project(1250, 0, 0)!;
    expect(below.x).toBeCloseTo(390, 6);
    expect(below.y).toBeCloseTo(290, 6);
  });

  it('has image right = -y and image down = -x', () => {
    const right = camera.project(1250, -500, 0)!;
    expect(right.x).toBeGreaterThan(390);
    expect(right.y).toBeCloseTo(290, 6);
    const down = camera.project(750, 0, 0)!;
    expect(down.y).toBeGreaterThan(290);
    expect(down.x).toBeCloseTo(390, 6);
  });

  it('sees nothing behind itself', () => {
    expect(camera.project(1250, 0, 4000)).toBeNull();
  });

  for (const distortion of [0, 0.1, 0.3, -0.1])
    it(`goes there and back with distortion ${distortion}`, () => {
      const tilted = new CameraModel({ ...overhead, distortion, q0: 0.72, q1: -0.68, q2: 0.08, q3: -0.1 });
      for (const height of [0, 21.5, 140])
        for (let u = 0; u <= 780; u += 130)
          for (let v = 0; v <= 580; v += 116) {
            const point = tilted.unproject(u, v, height)!;
            const pixel = tilted.project(point.x, point.y, height)!;
            expect(pixel.x).toBeCloseTo(u, 6);
            expect(pixel.y).toBeCloseTo(v, 6);
          }
    });

  it('does not fold points into the image with a negative distortion', () => {
    expect(distortRadius(0.5, -0.3)).not.toBeNull();
    expect(distortRadius(2, -0.3)).toBeNull();
    expect(new CameraModel({ ...overhead, distortion: -0.3 }).project(20000, 0, 0)).toBeNull();
  });

  it('does not meet the floor when it looks up', () => {
    const up = new CameraModel({ ...overhead, q0: 0, q1: 0, q2: 0, q3: 1, tx: 0, ty: 0, tz: -3500 });
    expect(up.unproject(390, 290, 0)).toBeNull();
  });
});
