// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { SettingsStep } from '../../api/types';
import { daysOf, whoOf } from './days';

const step = (at: Date, who: string): SettingsStep => ({ revision: 1, time: at.getTime() / 1000, who, what: '', changes: [] });

describe('days', () => {
  const now = new Date(2026, 2, 1, 9);
  const steps = [step(new Date(2026, 2, 1, 8), 'b'), step(new Date(2026, 1, 28, 23), 'a'), step(new Date(2026, 1, 28, 1), 'b'), step(new Date(2026, 1, 3), 'a')];
  it('group steps', () => {
    expect(daysOf(steps, now).map(({ title, steps: list }) => [title, list.length])).toEqual([['Today', 1], ['Yesterday', 2], ['2026-02-03', 1]]);
  });
  it('know who', () => expect(whoOf(steps)).toEqual(['a', 'b']));
});
