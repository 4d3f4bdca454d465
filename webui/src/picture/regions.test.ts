// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { regionPaths } from './regions';

const regions = { labels: ['clear', 'orange', 'blue'], boxes: [[1, 10, 20, 4, 6, 20], [2, 0, 0, 1, 1, 1], [1, 30, 40, 2, 2, 4]], total: 3 };
const picture = { width: 100, height: 80 };

describe('regions', () => {
  it('are boxes round their pixels, by label', () => {
    expect(regionPaths(regions, picture, 0)).toEqual([
      { label: 'orange', colour: 'rgb(255,138,31)', path: 'M10 20h4v6h-4zM30 40h2v2h-2z' },
      { label: 'blue', colour: 'rgb(58,116,255)', path: 'M0 0h1v1h-1z' },
    ]);
  });

  it('turn with the image', () => {
    expect(regionPaths(regions, picture, 1)[0]!.path).toMatch(/^M54 10h6v4h-6z/);
  });

  it('may be missing', () => {
    expect(regionPaths(null, picture, 0)).toEqual([]);
    expect(regionPaths(undefined, picture, 0)).toEqual([]);
  });
});
