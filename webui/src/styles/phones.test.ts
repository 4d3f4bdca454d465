// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { phoneConditions } from '../../phones';

describe('phones held sideways', () => {
  it('are phones', () => {
    expect(phoneConditions('(max-width: 760px)')).toBe('(max-width: 760px), (max-width: 960px) and (max-height: 480px)');
    expect(phoneConditions('(max-width: 760px), (pointer: coarse)')).toBe('(max-width: 760px), (max-width: 960px) and (max-height: 480px), (pointer: coarse)');
  });

  it('are nothing else', () => {
    expect(phoneConditions('(min-width: 761px) and (max-width: 1240px)'))
      .toBe('(min-width: 761px) and (max-width: 1240px) and (min-height: 481px), (min-width: 961px) and (max-width: 1240px)');
  });

  it('leave other conditions alone', () => {
    for (const one of ['(max-width: 400px)', '(min-width: 961px) and (max-height: 720px)', '(prefers-reduced-motion: reduce)']) expect(phoneConditions(one)).toBe(one);
  });
});
