// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { MatchLog, MatchLogNow } from '../../api/types';
import { factsOf, hintsOf, isWritten, nowText, sharesOf, usedText } from './words';

const at = (hour: number, minute: number) => new Date(2026, 6, 3, hour, minute).getTime() / 1000;
const disk = { used_bytes: 12e9, quota_bytes: 50e9, free_bytes: 100e9 };
const now = (changes: Partial<MatchLogNow> = {}): MatchLogNow => ({
  state: 'recording', name: '2026-07-03_14-05_GROUP_PHASE_Yellow-vs-Blue.log.gz', started_by: 'game_controller', begin_s: at(14, 5), seconds: 725, bytes: 34e6,
  messages: { vision: 40000, referee: 7000, tracked: 40000 }, lost: 0, refused: 0, error: '', ...changes,
});
const none = { name: null, started_by: null, begin_s: null, seconds: 0, bytes: 0, messages: { vision: 0, referee: 0, tracked: 0 } };
const log = (changes: Partial<MatchLog> = {}): MatchLog => ({
  name: '2026-07-03_14-05_GROUP_PHASE_Yellow-vs-Blue.log.gz', bytes: 34e6, begin_s: at(14, 6), seconds: 725,
  messages: { vision: 40000, referee: 7000, tracked: 1 }, goals: 3, pinned: false, problem: '', ...changes,
});

describe('the log of this moment', () => {
  const text = (changes: Partial<MatchLogNow>, free_bytes = disk.free_bytes) => nowText({ match_log: now(changes), disk: { ...disk, free_bytes } });
  it('is a sentence in each state', () => {
    expect(text({})).toMatchObject({ level: 'ok', text: 'Recording since 14:05: Yellow vs Blue, 12 min, 34 MB', more: 'Started by the game controller. It ends when the match is over.' });
    expect(text({ started_by: 'hand' }).more).toBe('Started by hand. It records until you press Stop.');
    expect(text({ ...none, state: 'waiting', error: 'the quota is used up' })).toMatchObject({ level: 'warn', text: 'No match can be recorded: the quota is used up' });
    expect(text({ state: 'paused' }).text).toBe('Paused: break. Yellow vs Blue, 12 min, 34 MB so far');
    expect(text({ ...none, state: 'left_out', error: '192.0.2.1 stopped its log' })).toMatchObject({ level: 'warn', text: 'This match is not recorded: 192.0.2.1 stopped its log' });
    expect(text({ ...none, state: 'waiting' }).text).toBe('Waiting for the game controller: recording starts when both teams are named and HALT ends');
    expect(text({ ...none, state: 'off' }).text).toBe('Off');
  });
  it('says why it failed, and what to do', () => {
    expect(text({ ...none, state: 'failed', error: 'No space left on device' }, 0)).toMatchObject({
      level: 'bad', text: 'Nothing is recorded: No space left on device', more: 'The disk is full. Delete logs or other files, then press Record.',
    });
    expect(text({ ...none, state: 'failed', error: 'Permission denied' }).more).toContain('Check the disk and the folder');
    expect(text({ ...none, state: 'failed' }).text).toBe('Nothing is recorded: the log cannot be written');
  });
  it('is none of those that are finished', () => {
    expect(isWritten(now(), now().name!)).toBe(true);
    expect(isWritten(now({ state: 'failed' }), now().name!)).toBe(false);
    expect(isWritten(now(), 'another.log.gz')).toBe(false);
  });
});

describe('hints', () => {
  const heard = { enabled: true, silent_s: 0.1 };
  const ids = (...args: Parameters<typeof hintsOf>) => hintsOf(...args).map(({ id }) => id);
  it('say that messages were lost', () => {
    expect(hintsOf(now({ lost: 1 }), heard)[0]!.text).toMatch(/^1 message was lost and is not in the log/);
    expect(hintsOf(now({ lost: 1200 }), heard)[0]!.text).toMatch(/^1.200 messages were lost and are not/);
  });
  it('say that no vision comes, but not at once', () => {
    const silent = { messages: { vision: 0, referee: 9, tracked: 0 } };
    expect(ids(now({ ...silent, seconds: 4 }), heard)).toEqual([]);
    expect(ids(now({ ...silent, seconds: 5 }), heard)).toEqual(['vision']);
    expect(ids(now({ ...silent, state: 'paused' }), heard)).toEqual([]);
  });
  it('say why nothing will start', () => {
    const waiting = now({ ...none, state: 'waiting' });
    expect(ids(waiting, heard)).toEqual([]);
    expect(ids(waiting, null)).toEqual([]);
    expect(ids(waiting, { enabled: true, silent_s: null })).toEqual(['controller']);
    expect(ids(waiting, { enabled: true, silent_s: 60 })).toEqual(['controller']);
    expect(hintsOf(waiting, { enabled: false, silent_s: null })[0]!.text).toContain('off in the settings');
    expect(ids(now({ ...none, state: 'off' }), { enabled: true, silent_s: null })).toEqual([]);
  });
});

describe('the disk', () => {
  it('is in words', () => {
    expect(usedText(disk)).toBe('12 GB of 50 GB');
    expect(usedText({ ...disk, quota_bytes: 0 })).toBe('12 GB');
  });
  it('has shares that fill the bar at most', () => {
    expect(sharesOf(disk, [log({ bytes: 5e9, pinned: true }), log({ bytes: 7e9 })])).toEqual({ pinned: 0.1, others: 0.14 });
    expect(sharesOf({ ...disk, used_bytes: 60e9 }, [log({ bytes: 70e9, pinned: true })])).toEqual({ pinned: 1, others: 0 });
    expect(sharesOf({ used_bytes: 0, quota_bytes: 0, free_bytes: 0 }, [])).toEqual({ pinned: 0, others: 0 });
  });
});

describe('a log', () => {
  it('has its facts', () => {
    expect(factsOf(log())).toMatchObject({ title: 'Yellow vs Blue', phase: 'Group phase', when: '2026-07-03 14:06', length: '12 min', size: '34 MB', goals: '3 goals', isReading: false });
    expect(factsOf(log()).messages.replace(/\s/g, ' ')).toBe('40 000 vision, 7 000 referee, 1 tracked messages');
  });
  it('says what is not known yet, or never will be', () => {
    const unread = { begin_s: null, seconds: null, messages: null, goals: null };
    expect(factsOf(log(unread))).toMatchObject({ when: '2026-07-03 14:05', length: '', goals: '', messages: '', isReading: true });
    expect(factsOf(log({ ...unread, problem: 'no log' })).isReading).toBe(false);
  });
});
