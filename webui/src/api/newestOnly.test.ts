// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { newestOnly } from './newestOnly';

describe('newestOnly', () => {
  it('has one on its way and skips what is out of date', async () => {
    const sent: [string, number][] = [];
    const answers: (() => void)[] = [];
    let rests = 0;
    const line = newestOnly<number>((name, value) => {
      sent.push([name, value]);
      return new Promise((resolve) => { answers.push(resolve); });
    }, () => { rests++; });
    const answer = async () => {
      answers.shift()!();
      await Promise.resolve();
      await Promise.resolve();
    };

    for (const value of [1, 2, 3]) line.put('Gain', value);
    line.put('Gamma', 7);
    expect(sent).toEqual([['Gain', 1]]);
    expect(line.isWaiting('Gain')).toBe(true);
    await answer();
    expect(sent).toEqual([['Gain', 1], ['Gain', 3]]);
    line.put('Gain', 4);
    await answer();
    await answer();
    expect(sent.slice(2)).toEqual([['Gamma', 7], ['Gain', 4]]);
    expect(rests).toBe(0);
    await answer();
    expect(rests).toBe(1);
    line.put('Gain', 5);
    expect(sent).toHaveLength(5);
  });
});
