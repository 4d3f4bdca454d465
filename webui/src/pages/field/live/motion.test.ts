// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { FieldKick, TrackedBall, TrackedRobot } from '../../../api/types';
import { divisionB } from '../../../testing/samples';
import { ballPath, carriedBall, carriedRobot, carryOf, isSeen } from './motion';

const models = { acc_slide: -3.4, acc_roll: -0.5, k_switch: 0.6, damping_xy_first_hop: 0.5, damping_xy_other_hops: 0.9, damping_z: 0.5 };
const ball = (changes: Partial<TrackedBall> = {}): TrackedBall => ({ x: 0, y: 0, z: 21.5, vx: 1000, vy: 0, vz: 0, visibility: 1, ...changes });
const kick = (changes: Partial<FieldKick> = {}): FieldKick => ({ number: 1, time: 100, x: 0, y: 0, vx: 2000, vy: 0, vz: 0, speed_m_s: 2, is_chip: false, landing: null, robot: null, ...changes });

describe('between two messages', () => {
  it('objects go on as they moved, but not for long', () => {
    const robot: TrackedRobot = { team: 'blue', id: 1, x: 100, y: 0, vx: 1000, vy: -500, orientation: 1, turn_rad_s: 2, sigma_mm: 1, visibility: 1 };
    expect(carriedRobot(robot, 0.1)).toEqual({ x: 200, y: -50, orientation: 1.2 });
    expect(carryOf(0.1)).toBe(0.1);
    expect(carryOf(-1)).toBe(0);
    expect(carryOf(8)).toBe(0.25);
  });
  it('a flying ball falls, and no farther than to the floor', () => {
    expect(carriedBall(ball({ z: 500, vz: 1000 }), 0.1, 21.5).z).toBeCloseTo(500 + 100 - 49.05);
    expect(carriedBall(ball({ z: 100, vz: -2000 }), 0.1, 21.5).z).toBe(21.5);
    expect(carriedBall(ball(), 0.1, 21.5)).toEqual({ x: 100, y: 0, z: 21.5 });
  });
  it('what was not seen for some images is not as if it were', () => {
    expect(isSeen({ visibility: 0.996 })).toBe(true);
    expect(isSeen({ visibility: 0.8 })).toBe(false);
  });
});

describe('where the ball goes', () => {
  it('rolls until it lies', () => {
    // 1 m/s and 0.5 m/s2: one metre.
    expect(ballPath(ball(), null, 100, models, divisionB)).toEqual({ landing: null, end: { x: 1000, y: 0 }, stops: true });
    expect(ballPath(ball({ vx: 0, vy: -1000 }), null, 100, models, divisionB)!.end.y).toBeCloseTo(-1000);
  });
  it('slides first after a kick', () => {
    // From 2 to 1.2 m/s at 3.4 m/s2, then to rest at 0.5 m/s2.
    const path = ballPath(ball({ vx: 2000 }), kick(), 100, models, divisionB)!;
    expect(path.end.x).toBeCloseTo((1000 * (4 - 1.44)) / 6.8 + (1000 * 1.44) / 1);
    // The same kick does not apply to a ball a minute later, nor to a slower ball.
    expect(ballPath(ball({ vx: 2000 }), kick(), 160, models, divisionB)!.end.x).toBeCloseTo(4000);
    expect(ballPath(ball(), kick(), 101, models, divisionB)!.end.x).toBeCloseTo(1000);
  });
  it('ends at the edge of the field', () => {
    const path = ballPath(ball({ x: 4000, vx: 3000, vy: 3000 }), null, 100, models, divisionB)!;
    expect(path).toEqual({ landing: null, end: { x: 4800, y: expect.closeTo(800) as number }, stops: false });
    expect(ballPath(ball(), null, 100, { ...models, acc_roll: 0 }, divisionB)).toMatchObject({ end: { x: 4800 }, stops: false });
    expect(ballPath(ball({ x: 9000 }), null, 100, models, divisionB)!.end.x).toBe(9000);
  });
  it('comes down first where it flies', () => {
    const path = ballPath(ball({ z: 21.5 + 4905, vx: 100 }), null, 100, models, divisionB)!;
    expect(path.landing!.x).toBeCloseTo(100);
    expect(path.end.x).toBeCloseTo(100 + 2.5);
  });
  it('is nowhere for one that lies still', () => expect(ballPath(ball({ vx: 30 }), null, 100, models, divisionB)).toBeNull());
});
