// SPDX-License-Identifier: Apache-2.0
// The title of the browser's tab: verdict, problem, site.
import type { Status } from '../api/types';
import { unrealWord } from './verdict';

/** `unreal`: GO without a real camera. */
export type Mood = 'go' | 'unreal' | 'nogo' | 'unknown';

export function moodOf(status: Status | null): Mood {
  if (!status) return 'unknown';
  if (!status.go) return 'nogo';
  return unrealWord(status.cameras) ? 'unreal' : 'go';
}

export const lostCameras = (status: Status): number[] => status.cameras.filter(({ state }) => state === 'lost').map(({ id }) => id);

/** "Camera 1 lost", "Cameras 0 and 2 lost", else the first check that failed. */
export function whatIsWrong(status: Status): string {
  const lost = lostCameras(status);
  if (lost.length === 1) return `Camera ${lost[0]} lost`;
  if (lost.length > 1) return `Cameras ${lost.slice(0, -1).join(', ')} and ${lost.at(-1)} lost`;
  return status.checks.find(({ state }) => state === 'fail')?.title ?? '';
}

/** `status` null: currently unknown. */
export function headline(status: Status | null, isStale: boolean, page: string, site: string): string {
  const mood = moodOf(status);
  const first = isStale ? ['No data'] : mood === 'nogo' ? ['NO-GO', whatIsWrong(status!)] : [page, ...(mood === 'unreal' ? [unrealWord(status!.cameras)] : [])];
  return [...first, site].filter(Boolean).join(' · ');
}

/** What became worse between two statuses, as a text; null: nothing. */
export function newTrouble(before: Status, now: Status): string | null {
  const known = lostCameras(before);
  const lost = lostCameras(now).filter((id) => !known.includes(id));
  if (lost.length) return whatIsWrong({ ...now, cameras: now.cameras.filter(({ id }) => lost.includes(id)) });
  return before.go && !now.go ? `NO-GO: ${whatIsWrong(now)}` : null;
}

const shapes: Record<Mood, string> = {
  go: '<circle cx="16" cy="16" r="15" fill="#1a7f37" stroke="none"/><path d="M9 16.5l5 5L23.5 11.5"/>',
  unreal: '<circle cx="16" cy="16" r="13.5" fill="#fff" stroke="#1a7f37"/><path stroke="#1a7f37" d="M9 16.5l5 5L23.5 11.5"/>',
  nogo: '<path d="M10 1h12l9 9v12l-9 9H10l-9-9V10z" fill="#c8102e" stroke="none"/><path d="M11 11l10 10M21 11L11 21"/>',
  unknown: '<circle cx="16" cy="16" r="15" fill="#6b7280" stroke="none"/><path d="M9 16h14"/>',
};

/** The tab's icon, distinguished by shape as well as by colour. */
export const sign = (mood: Mood): string =>
  `data:image/svg+xml,${encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><g stroke="#fff" stroke-width="4" fill="none" stroke-linecap="round" stroke-linejoin="round">${shapes[mood]}</g></svg>`)}`;
