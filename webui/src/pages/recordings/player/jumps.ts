// SPDX-License-Identifier: Apache-2.0
// Events that buttons and keys jump to.
import { laneOf, lanesOf, type TimedEvent } from '../timeline';
import { neighbour } from './clock';

export const ALL = 'all';

/** The options to jump to: all events, or one kind. */
export function jumpChoices(events: readonly TimedEvent[]): { value: string; text: string }[] {
  return [{ value: ALL, text: 'All events' }, ...lanesOf(events).map(({ kind, title }) => ({ value: kind, text: title }))];
}

/** Time of the next event of a kind, or of the previous one; null: there is none. */
export function jump(events: readonly TimedEvent[], kind: string, time: number, direction: 1 | -1): number | null {
  const times = events.filter((event) => kind === ALL || laneOf(event.kind).kind === kind).map(({ time_s }) => Math.max(0, time_s));
  return neighbour(times, time, direction);
}

/** The event at `time`, or the last one up to `within_s` before it; null: there is none. */
export function eventAt(events: readonly TimedEvent[], time: number, within_s = 1): TimedEvent | null {
  let best: TimedEvent | null = null;
  for (const event of events) if (event.time_s <= time + 1e-4 && time - event.time_s <= within_s && (!best || event.time_s >= best.time_s)) best = event;
  return best;
}
