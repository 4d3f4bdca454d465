// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { niceTop, seriesPaths } from './series';

const sample = (at: number, p50: number) => ({ at, p50, p99: p50, fps: 60, dropped: 0 });
const plane = { width: 60, height: 10, top: 2 };

describe('a minute as a line', () => {
  it('ends at the right with now', () => {
    const { line, area } = seriesPaths([sample(58_000, 1), sample(60_000, 2)], (s) => s.p50, 60_000, plane);
    expect(line).toBe('M58 5L60 0');
    expect(area).toBe('M58 10V5L60 0V10Z');
  });

  it('leaves a hole where nothing was measured, and forgets what is too old', () => {
    const { line } = seriesPaths([sample(-9000, 1), sample(10_000, 1), sample(30_000, 1)], (s) => s.p50, 60_000, plane);
    expect(line).toBe('M10 5M30 5');
  });

  it('never leaves its plane', () => {
    expect(seriesPaths([sample(60_000, 99)], (s) => s.p50, 60_000, plane).line).toBe('M60 0');
  });

  it('ends axes at round numbers', () => {
    expect([0, 0.87, 1.2, 7, 23].map(niceTop)).toEqual([1, 1, 1.5, 8, 30]);
  });
});
