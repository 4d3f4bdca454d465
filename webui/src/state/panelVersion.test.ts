// SPDX-License-Identifier: Apache-2.0
import 'vue'; // queries for a document when it is loaded
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';

vi.mock('../router', async () => ({ page: (await import('vue')).ref({ name: 'overview' }) }));
vi.mock('./live', async () => ({ isOpen: (await import('vue')).ref(true) }));

const NEW = 'assets/index-new.js';
const OLD = 'assets/index-old.js';
const reload = vi.fn();
const unregister = vi.fn();
const deleted: string[] = [];
let storage: Map<string, string>;
let registration: { active: object; installing: object | null; waiting: null; update(): Promise<void>; unregister(): void };

/** A worker that has this panel. */
const worker = (entry: string) => ({ postMessage: (asked: string, [port]: [MessagePort]) => port.postMessage(asked === entry) });

async function outdated() {
  vi.resetModules();
  const module = await import('./panelVersion');
  expect(await module.lookForPanel()).toBe(true);
  expect(module.isOutdated.value).toBe(true);
  return module;
}
const inTime = async <T>(promise: Promise<T>) => {
  await vi.advanceTimersByTimeAsync(60_000);
  return promise;
};

beforeEach(() => {
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'performance'] });
  vi.clearAllMocks();
  deleted.length = 0;
  storage = new Map();
  registration = { active: worker(OLD), installing: null, waiting: null, update: async () => {}, unregister };
  vi.stubGlobal('document', { querySelector: () => ({ src: `http://hall/${OLD}` }) });
  vi.stubGlobal('fetch', async () => ({ ok: true, text: async () => `<script type="module" src="./${NEW}"></script>` }));
  vi.stubGlobal('navigator', { serviceWorker: { getRegistration: async () => registration } });
  vi.stubGlobal('caches', { keys: async () => ['ssl-visiond-panel-0', 'another-page'], delete: async (name: string) => deleted.push(name) });
  vi.stubGlobal('sessionStorage', { getItem: (key: string) => storage.get(key) ?? null, setItem: (key: string, value: string) => storage.set(key, value) });
  vi.stubGlobal('location', { reload });
  // Real ports answer in tasks of their own, which fake timers do not advance.
  vi.stubGlobal('MessageChannel', class {
    port1: { onmessage?: (event: { data: unknown }) => void } = {};
    port2 = { postMessage: (data: unknown) => this.port1.onmessage?.({ data }) };
  });
});

afterEach(() => { vi.useRealTimers(); });

describe('the panel of an upgraded service', () => {
  it('is loaded once the service worker has it, and automatically only once', async () => {
    registration.active = worker(NEW);
    const { loadNewPanel } = await outdated();
    expect(await inTime(loadNewPanel(false))).toBe(true);
    expect(await inTime(loadNewPanel(false))).toBe(false);
    expect(reload).toHaveBeenCalledTimes(1);
    expect(unregister).not.toHaveBeenCalled();
  });

  it('is not loaded while a slow installation goes on, but after it', async () => {
    registration.installing = {};
    const { loadNewPanel } = await outdated();
    expect(await inTime(loadNewPanel(false))).toBe(false);
    expect(reload).not.toHaveBeenCalled();
    expect(unregister).not.toHaveBeenCalled();
    registration.installing = null;
    registration.active = worker(NEW);
    expect(await inTime(loadNewPanel(false))).toBe(true);
    expect(reload).toHaveBeenCalledTimes(1);
  });

  it('comes from the service when a button asks for it or the worker cannot get it; caches of other pages stay', async () => {
    registration.installing = {};
    const { loadNewPanel } = await outdated();
    expect(await inTime(loadNewPanel())).toBe(true);
    registration.installing = null;
    expect(await inTime(loadNewPanel(false))).toBe(true);
    expect(unregister).toHaveBeenCalledTimes(2);
    expect(deleted).toEqual(['ssl-visiond-panel-0', 'ssl-visiond-panel-0']);
  });

  it('leaves the old one where it is while the service does not answer', async () => {
    const { loadNewPanel } = await outdated();
    vi.stubGlobal('fetch', async () => { throw new TypeError('no link'); });
    expect(await inTime(loadNewPanel(false))).toBe(false);
    expect(unregister).not.toHaveBeenCalled();
    expect(storage.size).toBe(0);
  });

  it('does not interrupt what was begun meanwhile', async () => {
    registration.active = worker(NEW);
    const { loadNewPanel } = await outdated();
    expect(await inTime(loadNewPanel(false, () => false))).toBe(false);
    expect(reload).not.toHaveBeenCalled();
  });
});
