// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Pixels } from '../../api/types';
import { around, barsOf, lookOf, spanned, yuvAt } from './pixels';

const pixels = (part: Partial<Pixels>): Pixels => ({
  frame: 1, x: 10, y: 20, width: 3, height: 2, cell_px: 1, columns: 3, rows: 2, count: 6,
  yuv: btoa(String.fromCharCode(...Array.from({ length: 18 }, (_, i) => 10 * i))), labels: btoa('\x00\x01\x02\x03\x04\x05'),
  mean: [0, 0, 0], spread: [0, 0, 0], shares: [], histogram: { y: [], u: [], v: [] }, ...part,
});

describe('raw pixels', () => {
  it('finds the cell of a place', () => {
    const look = lookOf({ x: 12, y: 21 }, pixels({}))!;
    expect(look.index).toBe(5);
    expect(yuvAt(look, look.index)).toEqual([150, 160, 170]);
    expect(look.labels[look.index]).toBe(5);
  });
  it('knows that a Bayer image has a cell for four pixels', () => {
    expect(lookOf({ x: 15, y: 23 }, pixels({ cell_px: 2, width: 6, height: 4 }))?.index).toBe(5);
  });
  it('has nothing to show of what was left out', () => {
    expect(lookOf({ x: 9, y: 20 }, pixels({}))).toBeNull();
    expect(lookOf({ x: 10, y: 22 }, pixels({}))).toBeNull();
    expect(lookOf({ x: 10, y: 20 }, pixels({ yuv: null, labels: null }))).toBeNull();
  });
});

describe('rectangles', () => {
  it('lie around what was clicked', () => {
    expect(around({ x: 5, y: 6 }, 1)).toEqual({ x: 5, y: 6, width: 1, height: 1 });
    expect(around({ x: 5, y: 6 }, 9)).toEqual({ x: 1, y: 2, width: 9, height: 9 });
  });
  it('span two corners within the image', () => {
    const picture = { width: 100, height: 80 };
    expect(spanned({ x: 30, y: 40 }, { x: 10, y: 50 }, picture)).toEqual({ x: 10, y: 40, width: 21, height: 11 });
    expect(spanned({ x: 95, y: 75 }, { x: 400, y: -9 }, picture)).toEqual({ x: 95, y: 0, width: 5, height: 76 });
    expect(spanned({ x: -5, y: 3 }, { x: -1, y: 8 }, picture)).toBeNull();
  });
});

describe('histograms', () => {
  it('say which levels nearly all pixels have', () => {
    const counts = new Array<number>(64).fill(0);
    counts[3] = 1;
    counts[20] = 60;
    counts[21] = 30;
    counts[22] = 10;
    const { heights, range, bins } = barsOf(counts);
    expect(range).toEqual([80, 91]);
    expect(bins).toEqual([20, 22]);
    expect(heights[21]).toBe(0.5);
  });
  it('have no range where nothing is', () => {
    expect(barsOf(new Array<number>(64).fill(0)).range).toBeNull();
  });
});
