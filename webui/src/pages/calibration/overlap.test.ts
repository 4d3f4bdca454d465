// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Detections, Robot } from '../../api/types';
import { CameraModel } from '../../geometry/cameraModel';
import { median, meetings } from './overlap';

/** A camera 4 m above (0, 0), pointing straight down. */
const calibration = {
  focal_length: 400, principal_point_x: 390, principal_point_y: 290, distortion: 0, q0: 1, q1: 0, q2: 0, q3: 0, tx: 0, ty: 0, tz: 4000,
  pixel_image_width: 780, pixel_image_height: 580,
};
const model = new CameraModel(calibration);

const HEIGHT = 150;
const robotAt = (x: number, y: number, id = 3): Robot => {
  const pixel = model.project(x, y, HEIGHT)!;
  return { team: 'blue', id, x, y, orientation: 0, height: HEIGHT, confidence: 1, pixel_x: pixel.x, pixel_y: pixel.y };
};
const picture = (camera: number, t_capture: number, robots: Robot[]) => ({ camera, frame: 0, t_capture, robots, balls: [] }) as Detections;

describe('robots that two cameras see', () => {
  it('are compared at the same moment', () => {
    const theirs = { older: picture(1, 10, [robotAt(990, 0)]), newer: picture(1, 10.02, [robotAt(1030, 0)]) };
    // At 10.01 s the other camera reports it at x = 1010.
    const [met] = meetings(picture(0, 10.01, [robotAt(1000, 0)]), theirs, model);
    expect(met).toMatchObject({ camera: 1, inUse: expect.closeTo(10, 6), proposed: expect.closeTo(10, 6) });
    const shifted = new CameraModel({ ...calibration, tx: -10 });
    expect(meetings(picture(0, 10.01, [robotAt(1000, 0)]), theirs, shifted)[0]!.proposed).toBeCloseTo(0, 6);
  });

  it('do not meet before, after, or with another robot', () => {
    const theirs = { older: picture(1, 10, [robotAt(990, 0)]), newer: picture(1, 10.02, [robotAt(1030, 0)]) };
    const met = (t: number, id = 3) => meetings(picture(0, t, [robotAt(1000, 0, id)]), theirs, null).length;
    expect([met(9.99), met(10.03), met(10.01, 4), met(10.01)]).toEqual([0, 0, 0, 1]);
    expect(meetings(picture(0, 10.2, [robotAt(0, 0)]), { older: picture(1, 10, []), newer: picture(1, 11, []) }, null)).toEqual([]);
  });

  it('have a median', () => {
    expect([median([]), median([3, 1, 2]), median([4, 1])]).toEqual([null, 2, 1]);
  });
});
