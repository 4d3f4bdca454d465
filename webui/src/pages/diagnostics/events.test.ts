// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import type { EventEntry } from '../../api/types';
import { besideText, filterEvents, lastedText } from './events';

const entry = (more: Partial<EventEntry>): EventEntry => ({
  seq: 1, kind: 'alert', id: 'camera_lost', severity: 'bad', title: 'Camera 0 is lost', camera: 0, who: '',
  begin: 1_790_000_000, end: 1_790_000_133, seconds: 133, count: 1, ended_by: '', ...more,
});

test('bad only: alerts that are or were bad', () => {
  const entries = [entry({ seq: 4 }), entry({ seq: 3, severity: 'warn' }), entry({ seq: 2, kind: 'event', severity: 'info' }), entry({ seq: 1, end: null })];
  expect(filterEvents(entries, 'bad').map(({ seq }) => seq)).toEqual([4, 1]);
  expect(filterEvents(entries, 'all')).toEqual(entries);
});

test('how long an alert lasted', () => {
  expect(lastedText(entry({}))).toBe('2 min 13 s');
  expect(lastedText(entry({ end: null, seconds: 59.9 }))).toBe('59 s so far');
  expect(lastedText(entry({ seconds: 0.2 }))).toBe('under 1 s');
  expect(lastedText(entry({ seconds: 3660 }))).toBe('1 h 1 min');
  expect(lastedText(entry({ kind: 'event', seconds: 0 }))).toBe('');
});

test('what stands beside it', () => {
  expect(besideText(entry({}))).toBe('');
  expect(besideText(entry({ count: 3, ended_by: 'the service ended' }))).toBe('3 times · until the service ended');
  expect(besideText(entry({ kind: 'event', who: '10.0.0.7' }))).toBe('by 10.0.0.7');
});
