// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { BackupContents } from '../../api/types';
import { heldIn, movesTo } from './backup';

const contents: BackupContents = {
  time: 1_790_000_000, version: '1.2.3', computer: 'field-pc', site: '', cameras: [{ id: 0, name: 'left' }, { id: 3, name: '' }],
  tables: 2, profiles: [], calibrations: 1, steps: 1, passwords: false, keeps_passwords: true, files_elsewhere: [], changes: [], revision: 7,
};
const textOf = (name: string, changed: Partial<BackupContents> = {}) => heldIn({ ...contents, ...changed }).find((row) => row.name === name)?.text;

describe('what a backup holds', () => {
  it('is named', () => {
    expect(textOf('Cameras')).toBe('0 (left), 3');
    expect(textOf('Site')).toBe('no name');
    expect(textOf('Profiles')).toBe('none');
    expect(textOf('Profiles', { profiles: ['A', 'B'] })).toBe('A, B');
    expect(textOf('History')).toBe('1 step');
  });

  it('says what becomes of passwords', () => {
    expect(textOf('Passwords')).toBe('none');
    expect(textOf('Passwords', { passwords: true })).toBe('yes, but this computer keeps its own');
    expect(textOf('Passwords', { passwords: true, keeps_passwords: false })).toBe('yes; sign in with them afterwards');
  });

  it('may move the panel', () => {
    expect(movesTo(contents)).toBeNull();
    expect(movesTo({ ...contents, changes: [{ op: 'replace', path: '/panel/port', before: 8090, after: 0 }] })).toBeNull();
    expect(movesTo({ ...contents, changes: [{ op: 'replace', path: '/panel/port', before: 8090, after: 8091 }] })).toBe(8091);
  });
});
