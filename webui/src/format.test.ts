// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { clockTime, decimal, duration, figure, latencyMs, plural, stageTime, timeOfDay, timeOfDayMs } from './format';

describe('numbers as the panel writes them', () => {
  it('groups thousands', () => expect(figure(1204518)).toBe('1\u2009204\u2009518'));
  it('keeps three figures of a latency', () => expect([0.873, 9.996, 123.4].map(latencyMs)).toEqual(['0.87', '10.0', '123']));
  it('gives short stages in microseconds', () => {
    expect([1.24, 421.4, 4505.4, 12_340].map((us) => Object.values(stageTime(us)).join(' ')))
      .toEqual(['1.2 µs', '421 µs', '4\u2009505 µs', '12.3 ms']);
  });
  it('writes a true minus, and none before zero', () => expect([-157.64, -0.04].map((v) => decimal(v, 1))).toEqual(['−157.6', '0.0']));
  it('counts', () => expect([plural(1, 'ball'), plural(7, 'robot')]).toEqual(['1 ball', '7 robots']));
  it('tells times', () => expect([8.9, 245, 7500, 273600].map(duration)).toEqual(['8 s', '4 min', '2 h 5 min', '3 d 4 h']));
  it('tells the time of day', () => {
    const at = new Date(2026, 6, 3, 4, 5, 6).getTime() / 1000;
    expect([timeOfDay(at), timeOfDay(at, false)]).toEqual(['04:05:06', '04:05']);
    expect([at, at + 0.0704, at + 0.9999].map(timeOfDayMs)).toEqual(['04:05:06.000', '04:05:06.070', '04:05:07.000']);
  });
  it('tells when, with the day unless it is today', () => {
    const at = new Date(2026, 6, 3, 4, 5, 6);
    expect(clockTime(at.getTime() / 1000, at)).toBe('04:05:06');
    expect(clockTime(at.getTime() / 1000, new Date(2026, 6, 4))).toBe('2026-07-03 04:05:06');
  });
});
