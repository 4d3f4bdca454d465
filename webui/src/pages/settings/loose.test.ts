// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { looseText, looseValue } from './loose';

describe('loose values', () => {
  it('are what they look like', () => {
    expect(['5.2', 'true', ' auto ', '"5"', '{"a":1}', ''].map(looseValue)).toEqual([5.2, true, 'auto', '5', { a: 1 }, '']);
  });
  it('come back as they were', () => {
    for (const value of [5, '5', 'auto', true, null, [1], '']) expect(looseValue(looseText(value))).toEqual(value);
  });
});
