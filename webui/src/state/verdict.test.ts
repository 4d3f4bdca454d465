// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Check } from '../api/types';
import { camera } from '../testing/samples';
import { unrealText, unrealWord, verdictText } from './verdict';

const checks = (...states: Check['state'][]) => states.map((state) => ({ id: 'cameras', title: '', state, value: '', unit: '', text: '' }) satisfies Check);

describe('verdictText', () => {
  it('counts what fails first', () => {
    expect(verdictText(checks('pass', 'pass'))).toBe('2 of 2 pass');
    expect(verdictText(checks('pass', 'warn'))).toBe('1 of 2 pass, 1 warning');
    expect(verdictText(checks('pass', 'unknown', 'warn'))).toBe('1 of 3 pass, 1 warning, 1 not known yet');
    expect(verdictText(checks('fail', 'warn', 'warn'))).toBe('1 of 3 failed, 2 warnings');
  });
});

describe('unrealText', () => {
  it('says that no camera looks at the field', () => {
    expect(unrealText([camera()])).toBe('simulated images only');
    expect(unrealText([camera(), camera({ origin: 'recording' })])).toBe('recorded and simulated images only');
    expect(unrealText([camera(), camera({ origin: 'camera' })])).toBe('');
    expect(unrealText([])).toBe('');
    expect(unrealWord([camera()])).toBe('simulated');
  });
});
