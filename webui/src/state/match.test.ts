// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { clockText, stageText, type Match } from './match';

const match = (changes: Partial<Match>): Match => ({ stage: 'first_half', time_left_s: null, score: { yellow: 0, blue: 0 }, ...changes });

describe('a match in words', () => {
  it('has a clock where the stage has one', () => {
    expect(clockText(match({ time_left_s: 187.9 }))).toBe('3:07');
    expect(clockText(match({ time_left_s: 0.4 }))).toBe('0:00');
    expect(clockText(match({ time_left_s: -12.5 }))).toBe('−0:12');
    expect(clockText(match({}))).toBe('');
  });
  it('names the stage', () => {
    expect(stageText(match({ stage: 'shootout' }))).toBe('Shoot-out');
  });
});
