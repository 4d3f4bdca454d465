// SPDX-License-Identifier: Apache-2.0
// Parses the file names of match logs and clips: "2026-07-03_14-05_GROUP_PHASE_Yellow-vs-Blue.log.gz".
import { timeOfDay } from '../../format';

export interface LogName {
  /** "Yellow vs Blue", or the name given by the user. */
  title: string;
  /** "Group phase"; empty if the name has none. */
  phase: string;
  /** "2026-07-03 14:05" on the service's computer; empty if the name has none. */
  when: string;
}

/** The game controller's names. */
const PHASES: Record<string, string> = { GROUP_PHASE: 'Group phase', ELIMINATION_PHASE: 'Elimination phase', FRIENDLY: 'Friendly match', UNKNOWN_MATCH: '' };

const spaced = (text: string) => text.replaceAll('_', ' ').trim();

export function readName(file: string): LogName {
  const base = file.replace(/\.(?:log(?:\.gz)?|clip)$/, '');
  const [, day, hour, minute, more = ''] = /^(\d{4}-\d\d-\d\d)_(\d\d)-(\d\d)(?:-\d\d)?(?:_(.*))?$/.exec(base) ?? [];
  if (day === undefined) return { title: spaced(base) || file, phase: '', when: '' };
  const phase = Object.keys(PHASES).find((one) => more === one || more.startsWith(`${one}_`));
  const rest = phase === undefined ? more : more.slice(phase.length + 1);
  const [, yellow, blue] = /^(.+?)-vs-(.+)$/.exec(rest) ?? [];
  const title = yellow !== undefined && blue !== undefined ? `${spaced(yellow)} vs ${spaced(blue)}` : spaced(rest);
  return { title: title || 'Match log', phase: phase === undefined ? '' : PHASES[phase]!, when: `${day} ${hour}:${minute}` };
}

/** "2026-07-03 14:05" for a Unix time in seconds, in the viewer's time zone. */
export function dayAndTime(unixSeconds: number): string {
  const at = new Date(unixSeconds * 1000);
  const [month, day] = [at.getMonth() + 1, at.getDate()].map((value) => String(value).padStart(2, '0'));
  return `${at.getFullYear()}-${month}-${day} ${timeOfDay(unixSeconds, false)}`;
}

/** Longest name that can become part of a file name. */
export const NAME_LENGTH = 100;
/** Why the service would refuse a name; empty if it would not, or if there is no name. */
export function nameProblem(name: string): string {
  if (name.length > NAME_LENGTH) return `At most ${NAME_LENGTH} characters`;
  return /^[A-Za-z0-9 _-]*$/.test(name) ? '' : 'Use only A to Z, digits, spaces, - and _';
}
