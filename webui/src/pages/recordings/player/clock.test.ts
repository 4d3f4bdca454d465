// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { advance, indexAt, neighbour } from './clock';

describe('the clock of a player', () => {
  it('goes on by the speed, and stops at the end', () => {
    expect(advance(1, 0.1, 4, 10)).toEqual({ position: 1.4, isOver: false });
    expect(advance(9.9, 0.1, 4, 10)).toEqual({ position: 10, isOver: true });
    expect(advance(1, 0.1, 0.1, 10).position).toBeCloseTo(1.01);
  });
  it('stays where it was while the window was hidden', () => {
    expect(advance(1, 60, 16, 100)).toEqual({ position: 1, isOver: false });
  });
  it('finds the frame of a moment', () => {
    const times = [0, 0.1, 0.2, 0.3];
    expect(indexAt(times, 0.25)).toBe(2);
    expect(indexAt(times, 0.3 - 1e-9)).toBe(3);
    expect(indexAt(times, -1)).toBe(0);
    expect(indexAt(times, 9)).toBe(3);
    expect(indexAt([], 1)).toBe(-1);
  });
  it('finds what is next to a moment, but not the moment itself', () => {
    expect(neighbour([3, 1, 2], 2, 1)).toBe(3);
    expect(neighbour([3, 1, 2], 2, -1)).toBe(1);
    expect(neighbour([3, 1, 2], 3, 1)).toBeNull();
    expect(neighbour([], 3, -1)).toBeNull();
  });
});
