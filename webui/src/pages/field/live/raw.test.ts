// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import type { Detections, Robot } from '../../../api/types';
import { robot } from '../../../testing/samples';
import { colourOfCamera, RawReports } from './raw';

const seen = (camera: number, t_capture: number, robots: Robot[]): Detections => ({ camera, frame: 1, t_capture, robots, balls: [] });
const track = (vx: number) => ({ robots: [{ team: 'yellow' as const, id: 0, x: 0, y: 0, vx, vy: 0, orientation: 0, turn_rad_s: 0, sigma_mm: 1, visibility: 1 }] });

it('the newest of each camera, in order, until it is a second old', () => {
  const raw = new RawReports();
  raw.take(seen(1, 10, [robot()]), 0, null);
  raw.take(seen(0, 10, []), 500, null);
  expect(raw.of(600).map(({ camera }) => camera)).toEqual([0, 1]);
  expect(raw.of(1200).map(({ camera }) => camera)).toEqual([0]);
});

it('two cameras are compared at one moment', () => {
  const raw = new RawReports();
  raw.take(seen(0, 10, [robot({ x: 1000 }), robot({ id: 4 })]), 0, track(2000));
  // 10 ms later it has moved by 20 mm; the cameras disagree by the other 3 mm.
  raw.take(seen(1, 10.01, [robot({ x: 1023, y: -4 }), robot({ team: 'blue', x: 1000 })]), 0, track(2000));
  expect(raw.differences(10.02)).toEqual([{ team: 'yellow', id: 0, x: 1023, y: -4, dx: expect.closeTo(3) as number, dy: -4, time: 10.01 }]);
  expect(raw.differences(12)).toEqual([]);
});

it('a difference settles rather than jumps, and has the sign of the pair', () => {
  const raw = new RawReports();
  for (let i = 0; i < 200; i++) raw.take(seen(i % 2, 10 + i / 100, [robot({ x: i % 2 ? 5 : 0 })]), 0, null);
  expect(raw.differences(12)[0]!.dx).toBeCloseTo(5);
  raw.take(seen(0, 12, [robot({ x: 105 })]), 0, null);
  expect(raw.differences(12)[0]!.dx).toBeGreaterThan(2);
});

it('robots far apart, and images far apart, are not compared', () => {
  const raw = new RawReports();
  raw.take(seen(0, 10, [robot({ x: -1000 })]), 0, null);
  raw.take(seen(1, 10, [robot({ x: 1000 })]), 0, null);
  raw.take(seen(2, 10.5, [robot({ x: 1000 })]), 0, null);
  expect(raw.differences(10)).toEqual([]);
});

it('every camera has a colour', () => expect([colourOfCamera(0), colourOfCamera(7), colourOfCamera(8)]).toEqual(['--g1', '--g6', '--g1']));
