// SPDX-License-Identifier: Apache-2.0
// Go or No-Go in words.
import type { CameraStatus, Check } from '../api/types';
import { plural } from '../format';

/** "1 of 10 failed, 2 warnings" or "9 of 10 pass, 1 warning". */
export function verdictText(checks: readonly Check[]): string {
  const count = (state: Check['state']) => checks.filter((check) => check.state === state).length;
  const [failed, warned] = [count('fail'), count('warn')];
  const first = failed ? `${failed} of ${checks.length} failed` : `${count('pass')} of ${checks.length} pass`;
  return warned ? `${first}, ${plural(warned, 'warning')}` : first;
}

/** What images are that no camera over the field sends; empty for those of one. */
export const originWord = (origin: CameraStatus['origin']) => ({ camera: '', recording: 'recorded', simulation: 'simulated' })[origin];

/** "simulated": what all images are when no camera looks at the field, so that a verdict is not about it. Empty when one does. */
export function unrealWord(cameras: readonly CameraStatus[]): string {
  if (cameras.some(({ origin }) => origin === 'camera')) return '';
  return [...new Set(cameras.map(({ origin }) => originWord(origin)))].sort().join(' and ');
}

/** The same as a sentence has it: "simulated images only". */
export function unrealText(cameras: readonly CameraStatus[]): string {
  const word = unrealWord(cameras);
  return word && `${word} images only`;
}
