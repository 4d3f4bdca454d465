// SPDX-License-Identifier: Apache-2.0
// The verdict as texts.
import type { CameraStatus, Check } from '../api/types';
import { plural } from '../format';

/** "1 of 10 failed, 2 warnings" or "8 of 10 pass, 1 warning, 1 not known yet". */
export function verdictText(checks: readonly Check[]): string {
  const count = (state: Check['state']) => checks.filter((check) => check.state === state).length;
  const [failed, warned, unknown] = [count('fail'), count('warn'), count('unknown')];
  const first = failed ? `${failed} of ${checks.length} failed` : `${count('pass')} of ${checks.length} pass`;
  return [first, warned && plural(warned, 'warning'), unknown && `${unknown} not known yet`].filter(Boolean).join(', ');
}

/** The origin of images that are not from a camera over the field; empty for a camera. */
export const originWord = (origin: CameraStatus['origin']) => ({ camera: '', recording: 'recorded', simulation: 'simulated' })[origin];

/**
 * "simulated": the origin of all images if there is no real camera, so that a verdict is not about the field. Else
 * empty.
 */
export function unrealWord(cameras: readonly CameraStatus[]): string {
  if (cameras.some(({ origin }) => origin === 'camera')) return '';
  return [...new Set(cameras.map(({ origin }) => originWord(origin)))].sort().join(' and ');
}

/** The same for use in a sentence: "simulated images only". */
export function unrealText(cameras: readonly CameraStatus[]): string {
  const word = unrealWord(cameras);
  return word && `${word} images only`;
}
