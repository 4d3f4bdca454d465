// SPDX-License-Identifier: Apache-2.0
// Texts about the last seconds and about clips.
import type { Clip, ClipNow, LastSeconds } from '../api/types';
import { bytes } from '../bytes';
import { figure, plural } from '../format';
import { dayAndTime, readName } from '../pages/recordings/names';

/** Seconds as a text: "6.2", "10". */
export const secondsText = (seconds: number): string => (seconds < 9.95 ? String(Math.round(seconds * 10) / 10) : String(Math.round(seconds)));

/** Duration that every camera has in memory, s; 0: nothing. */
export function reach({ cameras }: LastSeconds): number {
  return cameras.length ? Math.min(...cameras.map(({ seconds }) => seconds)) : 0;
}
/** Duration in memory of the camera that reaches farthest back, s. */
export const farthest = ({ cameras }: LastSeconds): number => Math.max(0, ...cameras.map(({ seconds }) => seconds));

/** Duration for "Go back" and "Keep", whole seconds: `wished`, or less if less is in memory. */
export function goBackSeconds(last: LastSeconds, wished: number, camera?: number): number {
  const there = camera === undefined ? farthest(last) : last.cameras.find(({ id }) => id === camera)?.seconds ?? 0;
  return Math.min(wished, there < 1 ? 0 : Math.floor(there + 0.05));
}

export function lastSecondsText(last: LastSeconds): string {
  const { cameras } = last;
  const [least, most] = [reach(last), farthest(last)];
  if (!cameras.length || most <= 0) return 'Nothing is in memory yet';
  const seconds = secondsText(least) === secondsText(most) ? `The last ${secondsText(most)} s` : `The last ${secondsText(least)} to ${secondsText(most)} s`;
  return `${seconds} of ${plural(cameras.length, 'camera')} ${most >= 9.95 || cameras.length > 1 || most !== 1 ? 'are' : 'is'} in memory`;
}

export function imagesText({ images, every_nth }: LastSeconds): string {
  return images === 'whole' ? 'Whole images' : `Every ${ordinal(every_nth)} image`;
}
const ordinal = (n: number) => `${n}${n % 100 >= 11 && n % 100 <= 13 ? 'th' : ['th', 'st', 'nd', 'rd'][n % 10] ?? 'th'}`;

export const memoryText = ({ memory_bytes, wanted_bytes }: LastSeconds): string =>
  (wanted_bytes > memory_bytes ? `${bytes(memory_bytes)}; ${bytes(wanted_bytes)} needed for all` : bytes(memory_bytes));

/** Number of images that were never stored in memory. */
export const droppedOf = ({ cameras }: LastSeconds): number => cameras.reduce((sum, { dropped }) => sum + dropped, 0);

/** "Keeping… 420 images" */
export const keepingText = (frames: number): string => (frames > 0 ? `Keeping… ${plural(frames, 'image')}` : 'Keeping…');

export function clipNowText({ state, name, frames, bytes: size, error }: ClipNow): string {
  if (state === 'writing') return `Keeping ${clipTitle(name)}: ${plural(frames, 'image')}, ${bytes(size)} so far`;
  return state === 'failed' ? `The clip could not be kept: ${error || 'the service gave no reason'}` : '';
}

/** The name that a clip was given: "Look back". */
export function clipTitle(name: string): string {
  const { title } = readName(name);
  return title === 'Match log' ? 'Clip' : title.charAt(0).toUpperCase() + title.slice(1);
}

export interface ClipFacts {
  title: string;
  when: string;
  why: string;
  length: string;
  cameras: string;
  missing: string;
  size: string;
  isReading: boolean;
}

export function clipFacts(clip: Clip): ClipFacts {
  const { when } = readName(clip.name);
  const missing = clip.cameras.reduce((sum, one) => sum + one.missing, 0);
  return {
    title: clipTitle(clip.name),
    when: clip.begin_s === null ? when : dayAndTime(clip.begin_s),
    why: clip.why,
    length: clip.seconds === null ? '' : `${secondsText(clip.seconds)} s`,
    cameras: clip.cameras.length ? (clip.cameras.length === 1 ? `camera ${clip.cameras[0]!.id}` : plural(clip.cameras.length, 'camera')) : '',
    missing: missing ? `${figure(missing)} missing` : '',
    size: bytes(clip.bytes),
    isReading: !clip.problem && (clip.begin_s === null || clip.seconds === null),
  };
}
