// SPDX-License-Identifier: Apache-2.0
// Why an image is not live, in words.
import type { CameraState } from '../api/types';
import type { IconName } from '../components/icons';
import { duration } from '../format';

export interface PictureState {
  state: CameraState;
  error: string;
  /** No word from the daemon for this long, when that is too long. */
  silentSeconds: number | null;
  /** Age of the last image; null before the first. */
  age: number | null;
  /** What the service sends comes late or seldom. */
  isLinkSlow: boolean;
  /** Seconds for which the service itself had no new image of a camera that runs. */
  gapAtService: number;
}

export interface Trouble {
  icon: IconName;
  title: string;
  notes: string[];
  bad: boolean;
  /** The image is late but goes on: it stays as it is, with a mark on it. */
  isMark?: boolean;
}

/** Whether an image is not to be taken for a live one at all. */
export const hides = (trouble: Trouble | null): boolean => trouble !== null && !trouble.isMark;

/** A running camera's image may be this old before it counts as stuck. */
const STUCK_SECONDS = 3;
/** So old, an image is marked where the link is slow. */
const LATE_SECONDS = 1.5;

export function pictureTrouble({ state, error, silentSeconds, age, isLinkSlow, gapAtService }: PictureState): Trouble | null {
  const last = age === null ? 'No image yet' : `Last image ${duration(age)} old`;
  const notes = error ? [last, error] : [last];
  if (silentSeconds !== null) return { icon: 'unplugged', title: `No data for ${duration(silentSeconds)}`, notes: [last], bad: false };
  if (state === 'lost') return { icon: 'nocamera', title: 'Camera lost', notes, bad: true };
  if (state === 'opening') return { icon: 'camera', title: 'Opening camera', notes, bad: false };
  if (state === 'ended') return { icon: 'pause', title: 'Recording ended', notes: [last], bad: false };
  const isCameraSilent = gapAtService > STUCK_SECONDS;
  if (age === null) {
    return isLinkSlow && !isCameraSilent ? { icon: 'link', title: 'Slow link', notes: ['The first image is on its way'], bad: false }
      : { icon: 'camera', title: 'Waiting for an image', notes: [], bad: false };
  }
  // The service has newer images than this: they are late on their way here.
  if (!isCameraSilent && age > (isLinkSlow ? LATE_SECONDS : STUCK_SECONDS)) return { icon: 'link', title: 'Slow link', notes: [`image ${duration(age)} old`], bad: false, isMark: true };
  if (isCameraSilent && age > STUCK_SECONDS) return { icon: 'nocamera', title: `No image for ${duration(age)}`, notes, bad: true };
  return null;
}
