// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { maskPaths } from './mask';

const picture = { width: 100, height: 80 };
const triangle = { points: [[0, 0], [10, 0], [10, 20]] as [number, number][] };

describe('mask', () => {
  it('is drawn through the centres of its pixels', () => {
    expect(maskPaths({ include: [], exclude: [triangle] }, picture, 0)).toEqual({ include: [], exclude: ['M0.5 0.5L10.5 0.5L10.5 20.5Z'] });
  });
  it('turns with the picture', () => {
    expect(maskPaths({ include: [triangle], exclude: [] }, picture, 2)?.include).toEqual(['M99.5 79.5L89.5 79.5L89.5 59.5Z']);
  });
  it('is nothing where nothing is left out', () => {
    expect(maskPaths({ include: [], exclude: [] }, picture, 0)).toBeNull();
    expect(maskPaths(null, picture, 0)).toBeNull();
  });
});
