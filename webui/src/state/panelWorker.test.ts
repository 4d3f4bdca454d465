// SPDX-License-Identifier: Apache-2.0
// The service worker, built as in panelFiles.ts, with simulated caches and a simulated service.
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { transformWithEsbuild } from 'vite';
import source from '../../sw/sw.ts?raw';

const FILES = ['assets/index-1.js', 'assets/page-1.js', './'];
const NAME = 'ssl-visiond-panel-1';
const { code } = await transformWithEsbuild(source, 'sw.ts', {
  format: 'iife', define: { FILES: JSON.stringify(FILES), VERSION: '"1"', PREFIX: '"ssl-visiond-panel-"' },
});

type Handler = (event: object) => void;
let handlers: Record<string, Handler>;
let kept: Map<string, Map<string, Response>>;
let served: Record<string, string>;

function begin(): void {
  handlers = {};
  const open = (name: string) => {
    const cache = kept.get(name) ?? new Map<string, Response>();
    kept.set(name, cache);
    return { put: async (url: string, answer: Response) => { cache.set(url, answer); }, match: async (url: string) => cache.get(url) };
  };
  const caches = {
    open: async (name: string) => open(name), has: async (name: string) => kept.has(name), delete: async (name: string) => kept.delete(name), keys: async () => [...kept.keys()],
    match: async (url: string) => [...kept.values()].map((cache) => cache.get(url)).find(Boolean)?.clone(),
  };
  const self = { location: { href: 'http://hall/sw.js' }, addEventListener: (kind: string, handler: Handler) => { handlers[kind] = handler; }, skipWaiting: vi.fn(), clients: { claim: vi.fn() } };
  const fetch = async (url: string) => {
    const text = served[url.slice('http://hall/'.length) || './'];
    return new Response(text ?? '', { status: text === undefined ? 404 : 200 });
  };
  new Function('self', 'caches', 'fetch', code)(self, caches, fetch);
}
const run = (kind: string) => {
  let work: unknown;
  handlers[kind]!({ waitUntil: (promise: unknown) => { work = promise; } });
  return work as Promise<void>;
};

beforeEach(() => {
  kept = new Map();
  served = { 'assets/index-1.js': 'entry', 'assets/page-1.js': 'page', './': '<script type="module" crossorigin src="./assets/index-1.js"></script>' };
  begin();
});

describe('the service worker', () => {
  it('keeps all files, then forgets those of other panels only', async () => {
    kept.set('ssl-visiond-panel-0', new Map()).set('another-page', new Map());
    await run('install');
    expect([...kept.get(NAME)!.keys()]).toEqual(['http://hall/assets/index-1.js', 'http://hall/assets/page-1.js', 'http://hall/']);
    await run('activate');
    expect([...kept.keys()]).toEqual(['another-page', NAME]);
  });

  it('keeps nothing of an installation that failed', async () => {
    delete served['assets/page-1.js'];
    await expect(run('install')).rejects.toThrow('404');
    expect(kept.has(NAME)).toBe(false);
  });

  it('keeps what it had before that', async () => {
    await run('install');
    delete served['./'];
    await expect(run('install')).rejects.toThrow('404');
    expect(kept.get(NAME)!.size).toBe(3);
  });

  it('does not mix two panels when the service was upgraded between two files', async () => {
    served['./'] = served['./']!.replace('index-1', 'index-2');
    await expect(run('install')).rejects.toThrow('index-2');
    expect(kept.size).toBe(0);
  });

  it('tells which panel it has', () => {
    const answers: unknown[] = [];
    for (const data of ['assets/index-1.js', 'assets/index-2.js']) handlers.message!({ data, ports: [{ postMessage: (answer: unknown) => answers.push(answer) }] });
    expect(answers).toEqual([true, false]);
  });
});
