// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Component, Ref } from 'vue';
import { lazyPage } from './lazyPage';
import { page } from './router';

const version = vi.hoisted(() => ({ lookForPanel: vi.fn(), loadNewPanel: vi.fn() }));
vi.mock('./state/panelVersion', async () => ({ ...version, isOutdated: (await import('vue')).ref(true) }));
vi.mock('./router', async () => ({ page: (await import('vue')).ref({ name: 'field' }) }));
vi.mock('./shell/PageLoading.vue', () => ({ default: {} }));

const goTo = (name: string) => { (page as Ref<unknown>).value = { name }; };
const listeners = new Map<() => void, AbortSignal>();
const reload = vi.fn();

/** Loads the page as Vue does when it is shown. */
const open = (load: () => Promise<Component>) => (lazyPage(load) as unknown as { __asyncLoader(): Promise<Component> }).__asyncLoader();
const gone = () => Promise.reject(new Error('404'));

beforeEach(() => {
  vi.useFakeTimers();
  vi.clearAllMocks();
  version.lookForPanel.mockResolvedValue(true);
  version.loadNewPanel.mockResolvedValue(false);
  goTo('field');
  listeners.clear();
  vi.stubGlobal('addEventListener', (_kind: string, act: () => void, { signal }: { signal: AbortSignal }) => { listeners.set(act, signal); });
  vi.stubGlobal('document', { querySelectorAll: () => [] });
  const storage = new Map<string, string>();
  vi.stubGlobal('sessionStorage', { getItem: (key: string) => storage.get(key) ?? null, setItem: (key: string, value: string) => storage.set(key, value) });
  vi.stubGlobal('location', { reload });
});

afterEach(() => { vi.useRealTimers(); });

describe('a page that cannot be loaded', () => {
  it('is tried again when the new panel does not help', async () => {
    const load = vi.fn().mockImplementationOnce(gone).mockImplementationOnce(gone).mockResolvedValue({ name: 'Field' });
    const opened = open(load);
    await vi.advanceTimersByTimeAsync(10_000);
    expect(await opened).toEqual({ name: 'Field' });
    expect(load).toHaveBeenCalledTimes(3);
    expect(reload).toHaveBeenCalledTimes(1);
  });

  it('waits for the new panel that is being loaded', async () => {
    version.loadNewPanel.mockResolvedValue(true);
    const load = vi.fn(gone);
    void open(load);
    await vi.advanceTimersByTimeAsync(60_000);
    expect(load).toHaveBeenCalledTimes(1);
  });

  it('leaves nothing behind while it waits for the service', async () => {
    version.lookForPanel.mockResolvedValue(false);
    const opened = open(gone).catch(() => {});
    await vi.advanceTimersByTimeAsync(15_000);
    expect(listeners.size).toBe(10 + 1);
    expect([...listeners.values()].filter(({ aborted }) => !aborted)).toHaveLength(1);
    [...listeners.keys()].at(-1)!();
    await vi.advanceTimersByTimeAsync(0);
    expect(version.lookForPanel, 'asks at once when the browser is online').toHaveBeenCalledTimes(10 + 2);
    goTo('camera');
    await vi.advanceTimersByTimeAsync(1500);
    await opened;
  });

  it('is given up when it was left', async () => {
    version.lookForPanel.mockResolvedValue(false);
    const opened = open(gone);
    const failed = expect(opened).rejects.toThrow('404');
    await vi.advanceTimersByTimeAsync(3000);
    goTo('camera');
    await vi.advanceTimersByTimeAsync(1500);
    await failed;
    version.lookForPanel.mockClear();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(version.lookForPanel).not.toHaveBeenCalled();
  });
});
