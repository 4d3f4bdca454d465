// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { markExposure } from './exposure';

const RED = [255, 61, 94] as const;
const BLUE = [109, 125, 255] as const;
const picture = Uint8ClampedArray.from([
  250, 0, 0, 255, /**/ 249, 249, 249, 255, /**/ 6, 6, 6, 255,
  0, 7, 0, 255, /**/ 255, 255, 255, 255, /**/ 0, 0, 0, 255,
]);

describe('exposure marks', () => {
  it('lie on every pixel with a full channel and on every black one', () => {
    const marks = new Uint8ClampedArray(picture.length).fill(9);
    const share = markExposure(picture, 3, marks, { over: RED, under: BLUE });
    expect(share).toEqual({ over: 2 / 6, under: 2 / 6 });
    const painted = Array.from({ length: 6 }, (_, i) => (marks[i * 4 + 3]! ? [...marks.slice(i * 4, i * 4 + 3)] : null));
    expect(painted).toEqual([[...RED], null, [...BLUE], null, [...RED], [...BLUE]]);
  });

  it('are counted without a colour, but not painted', () => {
    const marks = new Uint8ClampedArray(picture.length).fill(9);
    expect(markExposure(picture, 3, marks, { over: RED })).toEqual({ over: 2 / 6, under: 2 / 6 });
    expect([2, 5].map((i) => marks[i * 4 + 3])).toEqual([0, 0]);
  });

  it('are striped along diagonals', () => {
    const width = 16;
    const white = new Uint8ClampedArray(width * 2 * 4).fill(255);
    const marks = new Uint8ClampedArray(white.length);
    markExposure(white, width, marks, { over: RED });
    const strength = Array.from({ length: width * 2 }, (_, i) => marks[i * 4 + 3]!);
    expect(new Set(strength).size).toBe(2);
    expect(strength.slice(width, 2 * width - 1)).toEqual(strength.slice(1, width));
  });
});
