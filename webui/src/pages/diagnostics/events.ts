// SPDX-License-Identifier: Apache-2.0
// Texts for the history of alerts and actions.
import type { EventEntry } from '../../api/types';
import { exactDuration, figure } from '../../format';

export type EventFilter = 'all' | 'bad';

export const eventFilters: readonly { filter: EventFilter; title: string }[] = [
  { filter: 'all', title: 'All' },
  { filter: 'bad', title: 'Faults only' },
];

export function filterEvents(entries: readonly EventEntry[], filter: EventFilter): readonly EventEntry[] {
  return filter === 'all' ? entries : entries.filter(({ kind, severity }) => kind === 'alert' && severity === 'bad');
}

/** Duration of an alert; empty for an action. */
export function lastedText({ kind, seconds, end }: EventEntry): string {
  if (kind !== 'alert') return '';
  return end === null ? `${exactDuration(seconds)} so far` : exactDuration(seconds);
}

/** "3 times · by 192.168.1.5 · until the service ended" */
export function besideText({ count, who, ended_by: endedBy }: EventEntry): string {
  return [count > 1 && `${figure(count)} times`, who && `by ${who}`, endedBy && `until ${endedBy}`].filter(Boolean).join(' · ');
}
