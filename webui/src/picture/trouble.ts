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
}

export interface Trouble {
  icon: IconName;
  title: string;
  notes: string[];
  bad: boolean;
}

/** A running camera's image may be this old before it counts as stuck. */
const STUCK_SECONDS = 3;

export function pictureTrouble({ state, error, silentSeconds, age }: PictureState): Trouble | null {
  const last = age === null ? 'No image yet' : `Last image ${duration(age)} old`;
  const notes = error ? [last, error] : [last];
  if (silentSeconds !== null) return { icon: 'unplugged', title: `No data for ${duration(silentSeconds)}`, notes: [last], bad: false };
  if (state === 'lost') return { icon: 'nocamera', title: 'Camera lost', notes, bad: true };
  if (state === 'opening') return { icon: 'camera', title: 'Opening camera', notes, bad: false };
  if (state === 'ended') return { icon: 'pause', title: 'Recording ended', notes: [last], bad: false };
  if (age === null) return { icon: 'camera', title: 'Waiting for an image', notes: [], bad: false };
  if (age > STUCK_SECONDS) return { icon: 'nocamera', title: `No image for ${duration(age)}`, notes, bad: true };
  return null;
}
