// SPDX-License-Identifier: Apache-2.0
// Why an image is not live, as texts.
import type { CameraState } from '../api/types';
import type { IconName } from '../components/icons';
import { duration } from '../format';

export interface PictureState {
  state: CameraState;
  error: string;
  /** Time without a message from the daemon; null while it is not too long. */
  silentSeconds: number | null;
  /** Age of the last image; null before the first. */
  age: number | null;
  /** The service's messages arrive late or rarely. */
  isLinkSlow: boolean;
  /** Seconds in which the service itself received no new image from a running camera. */
  gapAtService: number;
}

export interface Trouble {
  icon: IconName;
  title: string;
  notes: string[];
  bad: boolean;
  /** The image is late but continues: it stays visible, with a mark. */
  isMark?: boolean;
}

/** Whether an image must not be presented as live. */
export const hides = (trouble: Trouble | null): boolean => trouble !== null && !trouble.isMark;

/** A running camera's image may be this old before it counts as stuck. */
const STUCK_SECONDS = 3;
/** On a slow link, an image this old gets a mark. */
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
    return isLinkSlow && !isCameraSilent ? { icon: 'link', title: 'Slow link', notes: ['Waiting for the first image'], bad: false }
      : { icon: 'camera', title: 'Waiting for an image', notes: [], bad: false };
  }
  // The service has newer images: this one is delayed on its way here.
  if (!isCameraSilent && age > (isLinkSlow ? LATE_SECONDS : STUCK_SECONDS)) return { icon: 'link', title: 'Slow link', notes: [`image ${duration(age)} old`], bad: false, isMark: true };
  if (isCameraSilent && age > STUCK_SECONDS) return { icon: 'nocamera', title: `No image for ${duration(age)}`, notes, bad: true };
  return null;
}
