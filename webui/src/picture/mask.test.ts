// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { maskPaths, rectanglesPath } from './mask';

const picture = { width: 100, height: 80 };
const triangle = { points: [[0, 0], [10, 0], [10, 20]] as [number, number][] };

describe('mask', () => {
  it('is drawn through the centres of its pixels', () => {
    expect(maskPaths({ include: [], exclude: [triangle] }, [], picture, 0)).toEqual({ include: [], exclude: ['M0.5 0.5L10.5 0.5L10.5 20.5Z'], beyond: '' });
  });
  it('turns with the image', () => {
    expect(maskPaths({ include: [triangle], exclude: [] }, [], picture, 2)?.include).toEqual(['M99.5 79.5L89.5 79.5L89.5 59.5Z']);
  });
  it('has what lies beyond the field, by the edges of its pixels', () => {
    expect(maskPaths(null, [[0, 0, 100, 16]], picture, 0)?.beyond).toBe('M0 0L100 0L100 16L0 16Z');
    expect(maskPaths(null, [[0, 0, 100, 16]], picture, 2)?.beyond).toBe('M100 80L0 80L0 64L100 64Z');
    expect(rectanglesPath([[0, 0, 100, 16], [0, 16, 32, 64]])).toBe('M0 0h100v16h-100ZM0 16h32v64h-32Z');
  });
  it('is nothing where nothing is left out', () => {
    expect(maskPaths({ include: [], exclude: [] }, [], picture, 0)).toBeNull();
    expect(maskPaths(null, [], picture, 0)).toBeNull();
  });
});
