// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { robot } from '../../../testing/samples';
import { LostRobots, lostBetween } from './lost';

const seen = (time_s: number, ...ids: number[]) => ({ time_s, camera: 1, robots: ids.map((id) => robot({ id })) });

it('says which robots vanish from one frame to the next', () => {
  expect(lostBetween(seen(0, 1, 2), seen(0.1, 2, 3))).toEqual([{ time_s: 0.1, kind: 'lost', text: 'Camera 1 loses yellow 1' }]);
  // Found twice, lost once.
  expect(lostBetween(seen(0, 4, 4), seen(0.1))).toHaveLength(1);
});

it('finds them in whatever order frames come', () => {
  const lost = new LostRobots();
  expect(lost.take(2, seen(0.2))).toBe(false);
  expect(lost.take(0, seen(0, 7))).toBe(false);
  expect(lost.events).toEqual([]);
  expect(lost.take(1, seen(0.1, 7))).toBe(true);
  expect(lost.events).toEqual([{ time_s: 0.2, kind: 'lost', text: 'Camera 1 loses yellow 7' }]);
  expect(lost.take(1, seen(0.1))).toBe(false);
  expect(lost.knows(1)).toBe(true);
  expect(lost.knows(3)).toBe(false);
});
