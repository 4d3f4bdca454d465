// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { dayAndTime, nameProblem, NAME_LENGTH, readName } from './names';

describe('the name of a log', () => {
  it('tells the teams, the phase and the time', () => {
    expect(readName('2026-07-03_14-05_GROUP_PHASE_Yellow-vs-Blue.log.gz')).toEqual({ title: 'Yellow vs Blue', phase: 'Group phase', when: '2026-07-03 14:05' });
    expect(readName('2026-07-03_14-05-59_ELIMINATION_PHASE_TIGERs_Mannheim-vs-ER-Force.log.gz'))
      .toEqual({ title: 'TIGERs Mannheim vs ER-Force', phase: 'Elimination phase', when: '2026-07-03 14:05' });
    expect(readName('2026-07-03_14-05_UNKNOWN_MATCH_A-vs-B.log')).toEqual({ title: 'A vs B', phase: '', when: '2026-07-03 14:05' });
  });
  it('may be one that somebody gave', () => {
    expect(readName('2026-07-03_09-00_warm-up_test 2.log.gz')).toEqual({ title: 'warm-up test 2', phase: '', when: '2026-07-03 09:00' });
    expect(readName('2026-07-03_09-00.log.gz')).toEqual({ title: 'Match log', phase: '', when: '2026-07-03 09:00' });
    expect(readName('FRIENDLY_old.log.gz')).toEqual({ title: 'FRIENDLY old', phase: '', when: '' });
    expect(readName('.log.gz').title).toBe('.log.gz');
  });
});

it('tells a day and a time', () => {
  expect(dayAndTime(new Date(2026, 6, 3, 4, 5, 59).getTime() / 1000)).toBe('2026-07-03 04:05');
});

it('knows what the service would refuse as a name', () => {
  for (const name of ['', 'semi final 2', 'A_b-C9', 'x'.repeat(NAME_LENGTH)]) expect(nameProblem(name)).toBe('');
  for (const name of ['../x', 'a/b', 'ä', 'a.b']) expect(nameProblem(name)).toContain('A to Z');
  expect(nameProblem('x'.repeat(NAME_LENGTH + 1))).toBe('At most 100 characters');
});
