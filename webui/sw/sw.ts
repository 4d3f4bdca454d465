// SPDX-License-Identifier: Apache-2.0
// The panel's service worker: caches the panel's files, so that it opens at once over any link and without the service.
// It does not handle api/ or other hosts. The build inserts the file list.
declare const self: ServiceWorkerGlobalScope;
/** Relative to the panel's address; './' is the page itself. */
declare const FILES: readonly string[];
/** Changes with the contents of these files. */
declare const VERSION: string;

/** Prefix of the panel's cache names, from src/cachePrefix.ts. */
declare const PREFIX: string;

const NAME = PREFIX + VERSION;
const BASE = new URL('./', self.location.href);

/** After an upgrade between two requests, the page could belong to another panel than the listed files. */
async function checkPage(page: Response): Promise<void> {
  const entry = /<script[^>]*src="[^"]*?(assets\/[^"]+)"/.exec(await page.text())?.[1] ?? '';
  if (!FILES.includes(entry)) throw new Error(`the page wants ${entry}, which is not among the files`);
}

/** Loads one file at a time: the panel's images share the link. */
async function fill(cache: Cache): Promise<void> {
  for (const file of FILES) {
    const url = new URL(file, BASE).href;
    const isHashed = file.startsWith('assets/');
    const known = isHashed ? await caches.match(url) : undefined;
    const answer = known ?? await fetch(url, { cache: isHashed ? 'default' : 'no-cache' });
    if (!answer.ok) throw new Error(`${file}: ${answer.status}`);
    if (file === './') await checkPage(answer.clone());
    await cache.put(url, answer);
  }
}

/** A failure changes nothing; browsers try again. */
async function keepAll(): Promise<void> {
  const isNew = !await caches.has(NAME);
  try {
    await fill(await caches.open(NAME));
  } catch (error) {
    if (isNew) await caches.delete(NAME);
    throw error;
  }
}

async function forgetOthers(): Promise<void> {
  for (const name of await caches.keys()) if (name.startsWith(PREFIX) && name !== NAME) await caches.delete(name);
}

async function fromCache(url: string, request: Request): Promise<Response> {
  const kept = await caches.open(NAME).then((cache) => cache.match(url)).catch(() => undefined);
  return kept ?? fetch(request);
}

self.addEventListener('install', (event) => event.waitUntil(keepAll().then(() => self.skipWaiting())));
self.addEventListener('activate', (event) => event.waitUntil(forgetOthers().then(() => self.clients.claim())));

self.addEventListener('fetch', (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (request.method !== 'GET' || url.origin !== BASE.origin || !url.pathname.startsWith(BASE.pathname)) return;
  const path = url.pathname.slice(BASE.pathname.length);
  if (path.startsWith('api/')) return;
  // Only navigations: the page also fetches its own address, to ask the service for a newer panel.
  const isPage = path === '' && request.mode === 'navigate';
  if (isPage || FILES.includes(path)) event.respondWith(fromCache(new URL(path || './', BASE).href, request));
});

/** A page asks which panel it would get from this worker. */
self.addEventListener('message', ({ data, ports }) => ports[0]?.postMessage(FILES.includes(data)));

/** A click on a notification focuses the panel. */
self.addEventListener('notificationclick', (event) => {
  event.notification.close();
  event.waitUntil(self.clients.matchAll({ type: 'window' }).then(([panel]) => panel?.focus()));
});

export {};
