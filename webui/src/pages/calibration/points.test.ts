// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { CalibrationReport } from '../../api/types';
import { CameraModel } from '../../geometry/cameraModel';
import { asksForHeight, asksForPlusX, clampInto, isInside, knownOf, knownText, NOTHING_KNOWN, pointsOf, requestOf, seenPoints } from './points';

const size = { width: 780, height: 580 };
/** A camera 4 m high, pointing straight down. */
const model = new CameraModel({
  focal_length: 400, principal_point_x: 390, principal_point_y: 290, distortion: 0, q0: 1, q1: 0, q2: 0, q3: 0, tx: 0, ty: 0, tz: 4000,
  pixel_image_width: 780, pixel_image_height: 580,
});
const point = (name: string, x: number, y: number) => ({ name, x, y, field_x: 0, field_y: 0, off_px: 0, off_mm: 0, suspect: false });
const reportWith = (given: ReturnType<typeof point>[], control: ReturnType<typeof point>[], notes: string[] = []) =>
  ({ points: given, control_points: control, notes }) as unknown as CalibrationReport;

describe('points', () => {
  it('are proposed where a camera sees them, and only those in the image', () => {
    const named = [{ name: 'centre', field_x: 0, field_y: 0 }, { name: 'corner', field_x: 1000, field_y: 1000 }, { name: 'far', field_x: 9000, field_y: 0 }];
    expect(seenPoints(model, named, size)).toEqual([{ name: 'centre', x: 390, y: 290 }, { name: 'corner', x: 490, y: 190 }]);
  });

  it('of a report are those that were given, else those that were found in the image', () => {
    const control = [point('a', 10.04, 20), point('b', -9, 20)];
    expect(pointsOf(reportWith([], control), size)).toEqual([{ name: 'a', x: 10, y: 20 }]);
    expect(pointsOf(reportWith([point('c', -0.2, 1)], control), size)).toEqual([{ name: 'c', x: -0.2, y: 1 }]);
  });

  it('stay in the image, whose pixel centres are whole numbers', () => {
    expect(clampInto({ x: -5, y: 900 }, size)).toEqual({ x: 0, y: 579 });
    expect([isInside({ x: -0.5, y: 0 }, size), isInside({ x: 779.6, y: 0 }, size)]).toEqual([true, false]);
  });
});

describe('a request', () => {
  it('says only what is known', () => {
    expect(requestOf([{ x: 1, y: 2, name: '' }, { x: 3, y: 4, name: 'centre' }], NOTHING_KNOWN, false))
      .toEqual({ points: [{ x: 1, y: 2 }, { x: 3, y: 4, name: 'centre' }], force: false });
    const known = { height_mm: 4000, height_sigma_mm: 5, focal_px: 460, plus_x: 'up' as const, lines_measured_to: 'middle' as const };
    expect(requestOf([], known, true)).toEqual({ points: [], force: true, ...known });
    expect(requestOf([], { ...known, height_mm: null }, true)).not.toHaveProperty('height_sigma_mm');
    expect(knownOf({ ...known, points: [] })).toEqual(known);
    expect(knownText(known)).toBe('height 4000 mm, focal length 460 px, +x up, sizes to line centres');
    expect(knownText(NOTHING_KNOWN)).toBe('nothing given');
  });

  it('knows what the service asks for', () => {
    const says = (note: string) => reportWith([], [], [note]);
    expect(asksForHeight(says("The camera's height is only accurate to 134 mm, so places of robots' tops may be off by 5 mm. To improve this, measure the height and enter it."))).toBe(true);
    expect(asksForPlusX(says('Both ends of the field look alike: the +x half was taken to be at the top of the image. Name the points, or say where +x is.'))).toBe(true);
    expect([asksForHeight(null), asksForPlusX(says(''))]).toEqual([false, false]);
  });
});
