// SPDX-License-Identifier: Apache-2.0
// The events of a log along its length.
import type { MatchLogEvent, MatchLogEvents } from '../../api/types';

export type Kind = MatchLogEvent['kind'];

/** The lanes from top to bottom. */
export const lanes: readonly { kind: Kind; title: string; word: string }[] = [
  { kind: 'goal', title: 'Goals', word: 'Goal' },
  { kind: 'stage', title: 'Stages', word: 'Stage' },
  { kind: 'command', title: 'Commands', word: 'Command' },
  { kind: 'kick', title: 'Kicks', word: 'Kick' },
];
export const wordOf = (kind: Kind): string => lanes.find((lane) => lane.kind === kind)!.word;

export type Filter = 'all' | 'goals' | 'referee' | 'kicks';
export const filters: readonly { filter: Filter; title: string }[] = [
  { filter: 'all', title: 'All' }, { filter: 'goals', title: 'Goals' }, { filter: 'referee', title: 'Referee' }, { filter: 'kicks', title: 'Kicks' },
];
const KINDS: Record<Filter, readonly Kind[]> = { all: ['goal', 'stage', 'command', 'kick'], goals: ['goal'], referee: ['stage', 'command', 'goal'], kicks: ['kick'] };
export const filterEvents = (events: readonly MatchLogEvent[], filter: Filter): MatchLogEvent[] => events.filter(({ kind }) => KINDS[filter].includes(kind));

/** In the order of time, which the service promises and a graph needs. */
export const inOrder = (events: readonly MatchLogEvent[]): MatchLogEvent[] => [...events].sort((a, b) => a.time_s - b.time_s);

/** Never 0, so that there is a place for everything. */
export const lengthOf = ({ begin_s, end_s, events }: MatchLogEvents): number => Math.max(1, end_s - begin_s, ...events.map(({ time_s }) => time_s));

/** "12:05", "75:00": minutes and seconds since the begin. */
export function clock(seconds: number): string {
  const s = Math.max(0, Math.floor(seconds));
  return `${String(Math.floor(s / 60)).padStart(2, '0')}:${String(s % 60).padStart(2, '0')}`;
}

const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400, 28_800, 86_400];
const MAX_TICKS = 6;
/** Round times below the strip; at its very end there is no room for one. */
export function ticksOf(length: number): number[] {
  const step = STEPS_S.find((one) => length / one <= MAX_TICKS) ?? length;
  return Array.from({ length: Math.floor(length / step) + 1 }, (_, i) => i * step).filter((time) => time <= 0.95 * length);
}

/** The strip is so wide, whatever its pixels. */
export const WIDTH = 1000;
const placeOf = (time: number, length: number) => Math.round(Math.min(1, Math.max(0, time / length)) * WIDTH * 10) / 10;

/** A mark for each event of a kind, in a lane of height 1, as an SVG path. */
export const marksOf = (events: readonly MatchLogEvent[], kind: Kind, length: number): string =>
  events.filter((event) => event.kind === kind).map(({ time_s }) => `M${placeOf(time_s, length)} 0V1`).join('');

/** From each stage to the next: every second one, so that they can be told apart. */
export function bandsOf(events: readonly MatchLogEvent[], length: number): { x: number; width: number; isSecond: boolean }[] {
  const begins = events.filter(({ kind }) => kind === 'stage').map(({ time_s }) => placeOf(time_s, length));
  return begins.map((x, i) => ({ x, width: (begins[i + 1] ?? WIDTH) - x, isSecond: i % 2 === 1 }));
}

/** The event that is nearest to a time; -1: there is none. */
export function nearestEvent(events: readonly MatchLogEvent[], time: number): number {
  let best = -1;
  events.forEach(({ time_s }, i) => {
    if (best < 0 || Math.abs(time_s - time) < Math.abs(events[best]!.time_s - time)) best = i;
  });
  return best;
}
