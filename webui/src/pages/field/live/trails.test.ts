// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import type { FieldTracks } from '../../../api/types';
import { Trails } from './trails';

const tracks = (time: number, x: number): FieldTracks => ({
  number: 1, time, kick: null, balls: [],
  robots: [{ team: 'yellow', id: 3, x, y: 0, vx: 0, vy: 0, orientation: 0, turn_rad_s: 0, sigma_mm: 1, visibility: 1 }],
});
const pointsOf = (trails: Trails) => [...trails.all].flatMap(({ points }) => points);

it('a trail keeps two seconds, at fifteen points a second', () => {
  const trails = new Trails();
  for (let i = 0; i <= 120; i++) trails.add(tracks(100 + i / 30, 10 * i));
  const points = pointsOf(trails);
  expect(points.length).toBeGreaterThan(18);
  expect(points.length).toBeLessThanOrEqual(31);
  expect(points[0]!.t).toBeGreaterThanOrEqual(102 - 1e-6);
});

it('a trail breaks off where the object was away', () => {
  const trails = new Trails();
  trails.add(tracks(100, 0));
  trails.add(tracks(100.1, 50));
  trails.add(tracks(100.2, 3000));
  trails.add(tracks(101, 3000));
  expect(pointsOf(trails).map(({ isStart }) => isStart)).toEqual([true, false, true, true]);
});

it('trails end with their objects, and with the run of the service', () => {
  const trails = new Trails();
  trails.add(tracks(100, 0));
  trails.add({ ...tracks(103, 0), robots: [] });
  expect(pointsOf(trails)).toEqual([]);
  trails.add(tracks(104, 0));
  trails.add(tracks(50, 0));
  expect(pointsOf(trails).map(({ t }) => t)).toEqual([50]);
});
