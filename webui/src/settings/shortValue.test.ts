// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { shortValue } from './shortValue';

describe('shortValue', () => {
  it('says values in a few words', () => {
    expect(shortValue(85, 'mm')).toBe('85 mm');
    expect(shortValue(0.1 + 0.2)).toBe('0.3');
    expect(shortValue(true)).toBe('on');
    expect(shortValue(null)).toBe('none');
    expect(shortValue(undefined)).toBe('nothing');
    expect(shortValue(['segment', 'publish'])).toBe('segment, publish');
    expect(shortValue([{ a: 1 }])).toBe('1 entries');
    expect(shortValue({ a: 1, b: 2 })).toBe('2 values');
    expect(shortValue('x'.repeat(60))).toHaveLength(49);
  });
});
