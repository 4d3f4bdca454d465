// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import source from '../../../daemon/vision/label.h?raw';
import { labelColours, labelOf } from './labels';

describe('labels', () => {
  it('have the colours that the service draws', () => {
    const drawn = [...source.matchAll(/\{(\d+), (\d+), (\d+)\},\s*\/\/ (\w+)/g)].map(([, r, g, b, name]) => [name, [Number(r), Number(g), Number(b)]]);
    expect(drawn).toHaveLength(10);
    expect(labelColours).toEqual(Object.fromEntries(drawn));
  });

  it('are told from colours a little off', () => {
    expect(labelOf([250, 141, 36])).toBe('orange');
    expect(labelOf([50, 57, 60])).toBe('clear');
    expect(labelOf([3, 0, 5])).toBe('black');
  });
});
