// SPDX-License-Identifier: Apache-2.0
// The events of a log or a clip on a timeline.
import type { MatchLogEvent, MatchLogEvents } from '../../api/types';

export type Kind = MatchLogEvent['kind'];
/** An event of a log or a clip, or one found by the page. */
export interface TimedEvent { time_s: number; kind: string; text: string }

export interface Lane { kind: string; title: string; word: string }
/** The lanes of a log from top to bottom. */
export const lanes: readonly Lane[] = [
  { kind: 'goal', title: 'Goals', word: 'Goal' },
  { kind: 'stage', title: 'Stages', word: 'Stage' },
  { kind: 'command', title: 'Commands', word: 'Command' },
  { kind: 'kick', title: 'Kicks', word: 'Kick' },
];
/** Additional lanes of clips. */
const moreLanes: readonly Lane[] = [
  { kind: 'alert', title: 'Alerts', word: 'Alert' },
  { kind: 'lost', title: 'Lost robots', word: 'Lost robot' },
  { kind: 'difference', title: 'Differences', word: 'Difference' },
  { kind: 'other', title: 'Other', word: 'Event' },
];
const allLanes = [...lanes, ...moreLanes];
/** The lane of an event; unknown kinds belong to the others. */
export const laneOf = (kind: string): Lane => allLanes.find((lane) => lane.kind === kind) ?? allLanes.at(-1)!;
export const wordOf = (kind: string): string => laneOf(kind).word;
/** The lanes that contain events. */
export const lanesOf = (events: readonly TimedEvent[]): Lane[] => allLanes.filter((lane) => events.some(({ kind }) => laneOf(kind) === lane));

export type Filter = 'all' | 'goals' | 'referee' | 'kicks';
export const filters: readonly { filter: Filter; title: string }[] = [
  { filter: 'all', title: 'All' }, { filter: 'goals', title: 'Goals' }, { filter: 'referee', title: 'Referee' }, { filter: 'kicks', title: 'Kicks' },
];
const KINDS: Record<Filter, readonly Kind[]> = { all: ['goal', 'stage', 'command', 'kick'], goals: ['goal'], referee: ['stage', 'command', 'goal'], kicks: ['kick'] };
export const filterEvents = (events: readonly MatchLogEvent[], filter: Filter): MatchLogEvent[] => events.filter(({ kind }) => KINDS[filter].includes(kind));

/** Sorts by time; the service promises this order and a graph needs it. */
export const inOrder = <T extends { time_s: number }>(events: readonly T[]): T[] => [...events].sort((a, b) => a.time_s - b.time_s);

/** Length in s, at least 1, so that every event has a position. */
export const lengthOf = ({ begin_s, end_s, events }: MatchLogEvents): number => Math.max(1, end_s - begin_s, ...events.map(({ time_s }) => time_s));

/** "12:05", "75:00": minutes and seconds since the beginning. */
export function clock(seconds: number): string {
  const s = Math.max(0, Math.floor(seconds));
  return `${String(Math.floor(s / 60)).padStart(2, '0')}:${String(s % 60).padStart(2, '0')}`;
}

/** "00:03.25": as clock, with hundredths, for single frames. */
export function exactClock(seconds: number): string {
  const hundredths = Math.max(0, Math.floor(seconds * 100 + 1e-6));
  return `${clock(hundredths / 100)}.${String(hundredths % 100).padStart(2, '0')}`;
}

const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400, 28_800, 86_400];
const MAX_TICKS = 6;
/** Round times below the strip; at its very end there is no space for one. */
export function ticksOf(length: number): number[] {
  const step = STEPS_S.find((one) => length / one <= MAX_TICKS) ?? length;
  return Array.from({ length: Math.floor(length / step) + 1 }, (_, i) => i * step).filter((time) => time <= 0.95 * length);
}

/** Width of the strip in its own units, independent of its pixels. */
export const WIDTH = 1000;
const placeOf = (time: number, length: number) => Math.round(Math.min(1, Math.max(0, time / length)) * WIDTH * 10) / 10;

/** A mark for each event of a kind, in a lane of height 1, as an SVG path. */
export const marksOf = (events: readonly TimedEvent[], kind: string, length: number): string =>
  events.filter((event) => laneOf(event.kind).kind === kind).map(({ time_s }) => `M${placeOf(time_s, length)} 0V1`).join('');

/** Bands from each stage to the next; every second one is marked, to distinguish them. */
export function bandsOf(events: readonly TimedEvent[], length: number): { x: number; width: number; isSecond: boolean }[] {
  const begins = events.filter(({ kind }) => kind === 'stage').map(({ time_s }) => placeOf(time_s, length));
  return begins.map((x, i) => ({ x, width: (begins[i + 1] ?? WIDTH) - x, isSecond: i % 2 === 1 }));
}

/** Index of the event nearest to `time`; -1: there is none. */
export function nearestEvent(events: readonly TimedEvent[], time: number): number {
  let best = -1;
  events.forEach(({ time_s }, i) => {
    if (best < 0 || Math.abs(time_s - time) < Math.abs(events[best]!.time_s - time)) best = i;
  });
  return best;
}
