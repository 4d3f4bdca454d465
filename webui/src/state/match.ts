// SPDX-License-Identifier: Apache-2.0
// The match reported by the game controller, as texts.
import type { Status } from '../api/types';

export type Match = NonNullable<Status['referee']['match']>;

/** The game controller sends several times a second; after this long it counts as silent. */
export const QUIET_S = 5;

const stages: Record<Match['stage'], string> = {
  first_half_before: 'Before the first half',
  first_half: 'First half',
  half_time: 'Half time',
  second_half_before: 'Before the second half',
  second_half: 'Second half',
  extra_time_break: 'Break before extra time',
  extra_first_half_before: 'Before the first extra half',
  extra_first_half: 'First extra half',
  extra_half_time: 'Half time of extra time',
  extra_second_half_before: 'Before the second extra half',
  extra_second_half: 'Second extra half',
  shootout_break: 'Break before the shoot-out',
  shootout: 'Shoot-out',
  finished: 'Match over',
  unknown: 'Unknown stage',
};
export const stageText = ({ stage }: Match): string => stages[stage];

/** "3:07", or "−0:12" for a stage that overruns; '' if the stage has no clock. */
export function clockText({ time_left_s }: Match): string {
  if (time_left_s === null) return '';
  const seconds = Math.abs(Math.trunc(time_left_s));
  return `${time_left_s <= -1 ? '−' : ''}${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')}`;
}
