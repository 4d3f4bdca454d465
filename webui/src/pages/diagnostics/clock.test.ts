// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { clock, clockMs } from './clock';

it('tells the time of day', () => {
  const noon = new Date(2026, 5, 1, 12, 3, 4).getTime() / 1000;
  expect(clock(noon)).toBe('12:03:04');
  expect(clock(noon, false)).toBe('12:03');
  expect(clockMs(noon + 0.0704)).toBe('12:03:04.070');
  expect(clockMs(noon + 0.9999)).toBe('12:03:05.000');
});
