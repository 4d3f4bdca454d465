// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { MatchLogEvent } from '../../api/types';
import { bandsOf, clock, filterEvents, inOrder, lengthOf, marksOf, nearestEvent, ticksOf } from './timeline';

const event = (time_s: number, kind: MatchLogEvent['kind']): MatchLogEvent => ({ time_s, kind, text: `${kind} at ${time_s}` });
const events = [event(0, 'stage'), event(2, 'command'), event(30, 'kick'), event(60, 'goal'), event(75, 'stage')];

describe('the time line', () => {
  it('writes times since the begin', () => {
    expect([0, 9.9, 60, 725, 4500, -1].map(clock)).toEqual(['00:00', '00:09', '01:00', '12:05', '75:00', '00:00']);
  });
  it('has a length', () => {
    expect(lengthOf({ begin_s: 100, end_s: 220, events })).toBe(120);
    expect(lengthOf({ begin_s: 100, end_s: 110, events })).toBe(75);
    expect(lengthOf({ begin_s: 100, end_s: 100, events: [] })).toBe(1);
  });
  it('has few and round ticks', () => {
    expect(ticksOf(725)).toEqual([0, 300, 600]);
    expect(ticksOf(60)).toEqual([0, 10, 20, 30, 40, 50]);
    expect(ticksOf(600)).toEqual([0, 120, 240, 360, 480]);
    expect(ticksOf(1e7)).toEqual([0]);
    for (const length of [1, 7, 61, 1199, 5000, 90_000]) expect(ticksOf(length).length).toBeLessThanOrEqual(7);
  });
  it('marks events where they are', () => {
    expect(marksOf(events, 'goal', 120)).toBe('M500 0V1');
    expect(marksOf(events, 'stage', 75)).toBe('M0 0V1M1000 0V1');
    expect(marksOf([event(130, 'goal')], 'goal', 120)).toBe('M1000 0V1');
  });
  it('shades one stage after the other', () => {
    expect(bandsOf(events, 150)).toEqual([{ x: 0, width: 500, isSecond: false }, { x: 500, width: 500, isSecond: true }]);
    expect(bandsOf([], 150)).toEqual([]);
  });
});

describe('events', () => {
  it('are found by time and by kind', () => {
    expect(nearestEvent(events, 40)).toBe(2);
    expect(nearestEvent(events, 1e9)).toBe(4);
    expect(nearestEvent([], 0)).toBe(-1);
    expect(filterEvents(events, 'goals').map(({ time_s }) => time_s)).toEqual([60]);
    expect(filterEvents(events, 'referee').map(({ time_s }) => time_s)).toEqual([0, 2, 60, 75]);
    expect(filterEvents(events, 'kicks')).toHaveLength(1);
    expect(filterEvents(events, 'all')).toHaveLength(5);
  });
  it('are in the order of time', () => {
    expect(inOrder([...events].reverse()).map(({ time_s }) => time_s)).toEqual([0, 2, 30, 60, 75]);
  });
});
