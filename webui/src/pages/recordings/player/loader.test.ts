// SPDX-License-Identifier: Apache-2.0
import { afterEach, describe, expect, it, vi } from 'vitest';
import { ahead, bestOf, Loader, MOST_AT_ONCE, widthFor, type Want } from './loader';

const settle = () => new Promise<void>((resolve) => { setTimeout(resolve); });

/** Answers on demand. */
function link(limits: Record<string, number> = {}) {
  const open = new Map<string, { come: (value: string) => void; fail: (error: Error) => void }>();
  const asked: string[] = [];
  let changes = 0;
  const failures: unknown[] = [];
  const loader = new Loader(limits, () => { changes++; }, (error) => failures.push(error));
  const want = (key: string): Want<string> => ({
    key, kind: 'image',
    ask: () => new Promise((come, fail) => {
      asked.push(key);
      open.set(key, { come, fail });
    }),
  });
  return {
    loader, asked, failures, changes: () => changes,
    want: (...keys: string[]) => loader.want(keys.map(want)),
    async come(key: string) { open.get(key)!.come(key); await settle(); },
    async fail(key: string) { open.get(key)!.fail(new Error('no answer')); await settle(); },
  };
}

describe('what loads frames', () => {
  afterEach(() => { vi.useRealTimers(); });

  it('asks for the most important first, and never for more than two at a time', async () => {
    const { want, asked, come, loader } = link();
    want('a', 'b', 'c', 'd');
    expect(asked).toEqual(['a', 'b']);
    expect(loader.busy).toBe(MOST_AT_ONCE);
    await come('a');
    expect(asked).toEqual(['a', 'b', 'c']);
  });
  it('skips over a slow link what is not wanted any more', async () => {
    const { want, asked, come } = link();
    want('1', '2', '3');
    want('9', '10', '11');
    expect(asked).toEqual(['1', '2']);
    await come('1');
    expect(asked).toEqual(['1', '2', '9']);
  });
  it('asks for nothing twice', async () => {
    const { want, asked, come, loader, changes } = link();
    want('a');
    want('a');
    await come('a');
    want('a');
    expect(asked).toEqual(['a']);
    expect(loader.get('a')).toBe('a');
    expect(changes()).toBe(1);
  });
  it('forgets what was used longest ago', async () => {
    const { want, come, loader } = link({ image: 2 });
    for (const key of ['a', 'b']) { want(key); await come(key); }
    loader.get('a');
    want('c');
    await come('c');
    expect(['a', 'b', 'c'].filter((key) => loader.has(key))).toEqual(['a', 'c']);
  });
  it('tells a failure, and does not ask for the same at once', async () => {
    vi.useFakeTimers({ toFake: ['performance'] });
    const { want, asked, fail, failures } = link();
    want('a');
    await fail('a');
    want('a');
    expect(asked).toEqual(['a']);
    expect(failures).toHaveLength(1);
    vi.advanceTimersByTime(1500);
    want('a');
    expect(asked).toEqual(['a', 'a']);
  });
  it('is silent when it has ended', async () => {
    const { want, come, loader, changes, asked } = link();
    want('a', 'b', 'c');
    loader.end();
    await come('a');
    expect(changes()).toBe(0);
    expect(asked).toEqual(['a', 'b']);
  });
});

const times = Array.from({ length: 100 }, (_, i) => i * 0.1);

describe('which frame comes next', () => {
  it('is a neighbour while it stands still', () => {
    expect(ahead(times, 1, 1, 0.02, false)).toEqual([11, 9, 12]);
    expect(ahead(times, 0, 1, 0.02, false)).toEqual([1, 2]);
  });
  it('is the one after while it plays, or the one that will be due when it has come', () => {
    expect(ahead(times, 1, 1, 0.02, true)).toEqual([11, 12, 13, 14]);
    expect(ahead(times, 1, 1, 0.5, true)).toEqual([15, 20, 25, 30]);
    expect(ahead(times, 1, 16, 0.1, true)).toEqual([26, 42, 58, 74]);
    expect(ahead(times, 9.8, 1, 0.02, true)).toEqual([99]);
    expect(ahead([], 1, 1, 0.02, true)).toEqual([]);
  });
});

describe('which frame is shown', () => {
  const has = (...there: number[]) => (i: number) => there.includes(i);
  it('is that of the moment if it is there', () => {
    expect(bestOf(times, 1, 1, 0.02, true, has(10, 9))).toBe(10);
  });
  it('is the newest before it while it plays, but not one of long ago', () => {
    expect(bestOf(times, 1, 1, 0.02, true, has(8, 7))).toBe(8);
    expect(bestOf(times, 1, 1, 0.02, true, has(2))).toBe(-1);
    expect(bestOf(times, 1, 1, 0.3, true, has(2))).toBe(2);
    expect(bestOf(times, 5, 16, 0.02, true, has(2))).toBe(2);
  });
  it('is no other while it stands still', () => {
    expect(bestOf(times, 1, 1, 0.02, false, has(9))).toBe(-1);
  });
});

it('asks for smaller images over a slow link, but only while it moves', () => {
  expect(widthFor(1280, 0.05, true)).toBe(1280);
  expect(widthFor(1280, 0.3, true)).toBe(640);
  expect(widthFor(1280, 2, true)).toBe(320);
  expect(widthFor(1280, 2, false)).toBe(1280);
  expect(widthFor(200, 2, true)).toBe(200);
});
