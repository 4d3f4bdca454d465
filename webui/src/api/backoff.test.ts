// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { backoffMs } from './backoff';

it('waits longer each time, up to a limit', () => {
  expect([0, 1, 2, 3, 4, 20].map((attempt) => backoffMs(attempt, 0.5))).toEqual([500, 1000, 2000, 4000, 5000, 5000]);
  expect(backoffMs(0, 0)).toBeLessThan(backoffMs(0, 1));
});
