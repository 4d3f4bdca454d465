// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Status } from '../api/types';
import { headline, moodOf, newTrouble, sign, whatIsWrong } from './headline';

const status = (go: boolean, states: Record<number, string> = {}, failed: string[] = [], origin = 'camera') => ({
  go, cameras: [0, 1, 2].map((id) => ({ id, state: states[id] ?? 'running', origin })),
  checks: failed.map((title) => ({ title, state: 'fail' })),
}) as unknown as Status;

describe('what a tab says', () => {
  it('is the page while all is well', () => expect(headline(status(true), false, 'Camera', 'Hall A')).toBe('Camera · Hall A'));
  it('begins with the verdict and what is wrong', () => {
    expect(headline(status(false, { 1: 'lost' }, ['Cameras']), false, 'Camera', 'Hall A')).toBe('NO-GO · Camera 1 lost · Hall A');
    expect(headline(status(false, {}, ['Network']), false, 'Camera', 'Hall A')).toBe('NO-GO · Network · Hall A');
  });
  it('does not take simulated cameras for real ones', () => {
    const simulated = status(true, {}, [], 'simulation');
    expect(headline(simulated, false, 'Camera', 'Hall A')).toBe('Camera · simulated · Hall A');
    expect(moodOf(simulated)).toBe('unreal');
    expect(sign('unreal')).not.toBe(sign('go'));
    expect([status(true), status(false), null].map(moodOf)).toEqual(['go', 'nogo', 'unknown']);
    expect(moodOf(status(false, {}, [], 'simulation'))).toBe('nogo');
  });
  it('says that nothing is known', () => expect(headline(null, true, 'Camera', 'Hall A')).toBe('No data · Hall A'));
  it('names several cameras', () => expect(whatIsWrong(status(false, { 0: 'lost', 1: 'lost', 2: 'lost' }))).toBe('Cameras 0, 1 and 2 lost'));
});

describe('what became worse', () => {
  it('is each camera that was lost since', () => {
    expect(newTrouble(status(true), status(false, { 1: 'lost' }))).toBe('Camera 1 lost');
    expect(newTrouble(status(false, { 1: 'lost' }), status(false, { 0: 'lost', 1: 'lost' }))).toBe('Camera 0 lost');
  });
  it('is a verdict that turned', () => expect(newTrouble(status(true), status(false, {}, ['Network']))).toBe('NO-GO: Network'));
  it('is nothing while it stays or gets better', () => {
    expect(newTrouble(status(false, { 1: 'lost' }), status(false, { 1: 'lost' }))).toBeNull();
    expect(newTrouble(status(false, { 1: 'lost' }), status(true))).toBeNull();
  });
});
