// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { TrackedBall, TrackedRobot } from '../../../api/types';
import { camera, divisionB, status } from '../../../testing/samples';
import { apartText, heightText, missing, placeText, summaryOf, whoText } from './words';

const robot = (changes: Partial<TrackedRobot> = {}): TrackedRobot => ({ team: 'yellow', id: 0, x: 0, y: 0, vx: 0, vy: 0, orientation: 0, turn_rad_s: 0, sigma_mm: 1, visibility: 1, ...changes });
const ball = (changes: Partial<TrackedBall> = {}): TrackedBall => ({ x: 1200, y: -450, z: 21.5, vx: 3000, vy: 4000, vz: 0, visibility: 1, ...changes });
const stages = ['gather', 'track'].map((name) => ({ name, p50_us: 1, p99_us: 2, library: '', note: null }));
const now = { stages, other_cameras: [] };

it('figures', () => {
  expect(placeText(1204, -4)).toBe('1.20, 0.00');
  expect([heightText(49), heightText(431)]).toEqual(['', '0.43 m']);
  expect([apartText(3.42), apartText(12.3)]).toEqual(['3.4 mm', '12 mm']);
  expect([whoText({ robot: { team: 'blue', id: 7 } }), whoText({ robot: null })]).toEqual(['Blue 7', 'unknown']);
});

describe('the field in one sentence', () => {
  it('counts teams and says what the ball does', () => {
    expect(summaryOf({ robots: [robot(), robot({ id: 1 }), robot({ team: 'blue' })], balls: [ball()] }, divisionB))
      .toBe('Division B · 9 × 6 m: 2 yellow and 1 blue robot; the ball at 1.20, −0.45 m, 5.00 m/s');
  });
  it('says what is not seen, and that a ball flies', () => {
    expect(summaryOf({ robots: [robot({ visibility: 0.4 })], balls: [ball({ z: 431, visibility: 0.5 })] }, divisionB))
      .toBe('Division B · 9 × 6 m: 1 yellow and 0 blue robots, 1 of them not seen now; the ball at 1.20, −0.45 m, 5.00 m/s, 0.43 m high, not seen now');
    expect(summaryOf({ robots: [], balls: [] }, divisionB)).toMatch(/no ball$/);
  });
});

describe('what is missing', () => {
  it('nothing while there are fresh tracks', () => expect(missing(status(), now, 5, 0.1)).toBeNull());
  it('is told from the nearest cause', () => {
    expect(missing(null, now, 5, 0.1)?.text).toMatch(/cannot be reached/);
    expect(missing(status(), { stages: [], other_cameras: [] }, 0, null)).toMatchObject({ text: 'The field’s stack is empty, so nothing is tracked.', page: 'settings', place: 'field/stack' });
    expect(missing(status(), { ...now, stages: stages.slice(0, 1) }, 0, null)?.text).toMatch(/no stage “track”/);
    expect(missing(status({ cameras: [] }), now, 0, null)?.text).toMatch(/no camera yet/);
    expect(missing(status({ cameras: [camera({ calibration: null })] }), now, 0, null)).toMatchObject({ page: 'calibration' });
    expect(missing(status({ cameras: [camera({ state: 'lost' }), camera({ id: 1, calibration: null })] }), now, 9, 4)?.text).toBe('No calibrated camera sends images.');
    expect(missing(status(), now, 0, null)?.text).toBe('Nothing has been tracked yet.');
    expect(missing(status(), now, 7, 65)?.text).toBe('Nothing new has been tracked for 1 min.');
  });
  it('cameras of other computers are cameras', () => {
    expect(missing(status({ cameras: [] }), { stages, other_cameras: [{ camera: 4, address: '10.0.0.4', is_used: true, robots: 0, balls: 0, clock_correction_ms: 0 }] }, 0, null)?.text).toBe('Nothing has been tracked yet.');
  });
});
