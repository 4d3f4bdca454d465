// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { axisFor, seriesPaths } from './series';

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
    expect(axisFor(0.87).ticks).toEqual([0, 0.25, 0.5, 0.75, 1]);
    expect(axisFor(1.4).ticks).toEqual([0, 0.5, 1, 1.5]);
    expect(axisFor(23).ticks).toEqual([0, 10, 20, 30]);
    expect(axisFor(8).ticks).toEqual([0, 2, 4, 6, 8]);
    expect(axisFor(0).top).toBeGreaterThan(0);
  });
});
