// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { ALL, eventAt, jump, jumpChoices } from './jumps';

const events = [
  { time_s: -0.2, kind: 'command', text: 'Stop' }, { time_s: 1, kind: 'kick', text: 'yellow 3' }, { time_s: 2, kind: 'lost', text: 'Camera 0 loses blue 1' },
  { time_s: 3, kind: 'of-tomorrow', text: 'Something new' },
];

it('offers what there is', () => {
  expect(jumpChoices(events).map(({ text }) => text)).toEqual(['All events', 'Commands', 'Kicks', 'Lost robots', 'Other']);
  expect(jumpChoices([])).toHaveLength(1);
});

it('jumps to the next and to the one before, of all or of a kind', () => {
  expect(jump(events, ALL, 1, 1)).toBe(2);
  expect(jump(events, 'other', 1, 1)).toBe(3);
  expect(jump(events, 'kick', 1, 1)).toBeNull();
  // Events before the beginning count as being at it.
  expect(jump(events, ALL, 0.5, -1)).toBe(0);
  expect(jump(events, ALL, 0, -1)).toBeNull();
});

it('says what has just happened', () => {
  expect(eventAt(events, 1.5)?.text).toBe('yellow 3');
  expect(eventAt(events, 0.9)).toBeNull();
});
