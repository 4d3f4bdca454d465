// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { CameraModel } from '../geometry/cameraModel';
import { camera, robot } from '../testing/samples';
import { marks, placeTags } from './marks';

const model = new CameraModel(camera().calibration!);
const radii = { robot: 90, ball: 21.5 };

function seen(x: number, y: number, orientation = 0, id = 0) {
  const pixel = model.project(x, y, 140)!;
  return robot({ id, x, y, orientation, pixel_x: pixel.x, pixel_y: pixel.y });
}
const header = (robots: ReturnType<typeof seen>[]) =>
  ({ camera: 0, frame: 1, t_capture: 0, picture: 'camera' as const, width: 780, height: 580, robots, balls: [] });

describe('marks', () => {
  it('draws a robot looking along +x to the right in an image laid as the field lies', () => {
    const [mark] = marks(header([seen(1250, 0)]), radii, model, 1).robots;
    expect(mark!.ahead.x).toBeCloseTo(1, 2);
    expect(mark!.ahead.y).toBeCloseTo(0, 2);
    expect(mark!.centre.x).toBeCloseTo(580 - 290.5, 3);
    expect(mark!.radius).toBeCloseTo((90 * 600) / (3500 - 140), 0);
  });

  it('looks up for +y', () => {
    expect(marks(header([seen(1250, 0, Math.PI / 2)]), radii, model, 1).robots[0]!.ahead.y).toBeCloseTo(-1, 2);
  });

  it('draws no heading without a calibration', () => {
    expect(marks(header([seen(1250, 0)]), radii, null, 0).robots[0]).toMatchObject({ heading: '', ahead: { x: 0, y: 0 } });
  });

  it('tells doubles apart', () => {
    expect(marks(header([seen(0, 0), seen(500, 0)]), radii, model, 1).robots.map((m) => m.key)).toEqual(['yellow0', 'yellow0/1']);
  });

  it('turns things that resemble robots with the image', () => {
    const missed = { ...header([]), misses: [{ pixel_x: 100, pixel_y: 50, radius: 20, text: '3 of 5 dots are at their places' }] };
    expect(marks(missed, radii, model, 0).misses).toEqual([{ centre: { x: 100.5, y: 50.5 }, radius: 20, text: '3 of 5 dots are at their places' }]);
    expect(marks(missed, radii, model, 1).misses[0]!.centre).not.toEqual({ x: 100.5, y: 50.5 });
    expect(marks(header([]), radii, model, 0).misses).toEqual([]);
  });

  it('puts the tag where the robot does not look', () => {
    const up = marks(header([seen(1250, 0, Math.PI / 2)]), radii, model, 1);
    expect(placeTags(up, 1, new Map())[0]!.offset.y).toBeGreaterThan(0);
    const right = marks(header([seen(1250, 0, 0)]), radii, model, 1);
    expect(placeTags(right, 1, new Map())[0]!.offset.y).toBeLessThan(0);
  });

  it('keeps tags apart', () => {
    const pair = marks(header([seen(1250, 0, 0, 1), seen(1250, 230, 0, 2)]), radii, model, 1);
    const [low, high] = placeTags(pair, 1, new Map());
    const y = (tag: NonNullable<typeof low>) => tag.centre.y + tag.offset.y;
    expect(Math.abs(y(low!) - y(high!))).toBeGreaterThan(15);
  });
});
