// SPDX-License-Identifier: Apache-2.0
// Follows and filters the service's log.
import type { LogLevel, LogLine, LogLines } from '../../api/types';

/** More than the service keeps: lines from before a restart stay readable. */
const MOST_LINES = 2000;

export const levels: readonly LogLevel[] = ['debug', 'info', 'warning', 'error'];

/** Filters by level: this level and worse. */
export const levelFilters = [
  { level: 'debug', title: 'All' },
  { level: 'info', title: 'Info' },
  { level: 'warning', title: 'Warnings' },
  { level: 'error', title: 'Errors' },
] as const satisfies readonly { level: LogLevel; title: string }[];

/** The lines with the new ones of the answer appended, oldest first. */
export function followLog(lines: readonly LogLine[], { lines: answer }: LogLines): readonly LogLine[] {
  const known = new Set(lines.map(({ seq, time }) => `${seq} ${time}`));
  const news = answer.filter(({ seq, time }) => !known.has(`${seq} ${time}`));
  return news.length ? [...lines, ...news].slice(-MOST_LINES) : lines;
}

/** The lines of this level and worse that contain all words. */
export function filterLog(lines: readonly LogLine[], level: LogLevel, search: string): LogLine[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  const least = levels.indexOf(level);
  return lines.filter((line) => {
    if (levels.indexOf(line.level) < least) return false;
    const text = line.text.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** Warnings and errors of the second that ends at `time`. */
export const troubleAt = (lines: readonly LogLine[], time: number) =>
  lines.filter((line) => levels.indexOf(line.level) >= levels.indexOf('warning') && line.time > time - 1 && line.time <= time);

/** Format for a bug report: one line each, with date and UTC. */
export const logAsText = (lines: readonly LogLine[]) =>
  lines.map(({ time, level, text }) => `${new Date(time * 1000).toISOString()} ${level.padEnd(7)} ${text}\n`).join('');
