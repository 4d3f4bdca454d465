// SPDX-License-Identifier: Apache-2.0
// Go or No-Go in words.
import type { Check } from '../api/types';
import { plural } from '../format';

/** "1 of 10 failed, 2 warnings" or "9 of 10 pass, 1 warning". */
export function verdictText(checks: readonly Check[]): string {
  const count = (state: Check['state']) => checks.filter((check) => check.state === state).length;
  const [failed, warned] = [count('fail'), count('warn')];
  const first = failed ? `${failed} of ${checks.length} failed` : `${count('pass')} of ${checks.length} pass`;
  return warned ? `${first}, ${plural(warned, 'warning')}` : first;
}
