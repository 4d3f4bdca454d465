// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import type { LogLevel, LogLine } from '../../api/types';
import { filterLog, followLog, logAsText, troubleAt } from './log';

const line = (seq: number, level: LogLevel, text: string, time = 1000 + seq): LogLine => ({ seq, time, level, text });
const lines = [line(1, 'debug', 'a thing'), line(2, 'info', 'Camera 0: opened'), line(3, 'warning', 'camera 1: late'), line(4, 'error', 'camera 0: lost')];

it('adds lines once, also after a restart of the service', () => {
  const more = followLog(lines, { lines: [lines[3]!, line(5, 'info', 'next')], next: 5 });
  expect(more.map(({ seq }) => seq)).toEqual([1, 2, 3, 4, 5]);
  expect(followLog(more, { lines: [], next: 5 })).toBe(more);
  const restarted = followLog(more, { lines: [line(1, 'info', 'begin', 2000)], next: 1 });
  expect(restarted.at(-1)).toMatchObject({ seq: 1, text: 'begin' });
  expect(restarted.length).toBe(6);
});

it('keeps the newest 2000', () => {
  const many = Array.from({ length: 2500 }, (_, i) => line(i + 1, 'info', ''));
  expect(followLog([], { lines: many, next: 2500 }).map(({ seq }) => seq).slice(0, 1)).toEqual([501]);
});

it('filters by level and by words', () => {
  const seqs = (level: LogLevel, search = '') => filterLog(lines, level, search).map(({ seq }) => seq);
  expect(seqs('debug')).toEqual([1, 2, 3, 4]);
  expect(seqs('info')).toEqual([2, 3, 4]);
  expect(seqs('warning')).toEqual([3, 4]);
  expect(seqs('error')).toEqual([4]);
  expect(seqs('debug', '  CAMERA 0 ')).toEqual([2, 4]);
  expect(seqs('warning', 'opened')).toEqual([]);
});

it('finds the trouble of a second', () => {
  expect(troubleAt(lines, 1003.5).map(({ seq }) => seq)).toEqual([3]);
  expect(troubleAt(lines, 1002)).toEqual([]);
});

it('writes lines for a report', () => {
  expect(logAsText([line(1, 'info', 'ready', 1790000000.25)])).toBe('2026-09-21T14:13:20.250Z info    ready\n');
});
