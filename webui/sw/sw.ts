// SPDX-License-Identifier: Apache-2.0
// The panel's service worker: keeps the panel's own files, so that it opens at once over any link and without the service.
// What is under api/ and all of other hosts it never touches. The build fills in what there is to keep.
declare const self: ServiceWorkerGlobalScope;
/** Relative to the panel's address; './' is the page itself. */
declare const FILES: readonly string[];
/** Another one for every other content of these files. */
declare const VERSION: string;

const PREFIX = 'ssl-visiond-panel-';
const NAME = PREFIX + VERSION;
const BASE = new URL('./', self.location.href);

/** One file after the other: the panel's images share the link. What fails leaves all as it was. */
async function keepAll(): Promise<void> {
  const cache = await caches.open(NAME);
  for (const file of FILES) {
    const url = new URL(file, BASE).href;
    const isHashed = file.startsWith('assets/');
    const known = isHashed ? await caches.match(url) : undefined;
    const answer = known ?? await fetch(url, { cache: isHashed ? 'default' : 'no-cache' });
    if (!answer.ok) throw new Error(`${file}: ${answer.status}`);
    await cache.put(url, answer);
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
  // The page asks for its own address, too, to learn whether the service has a newer panel.
  const isPage = path === '' && request.mode === 'navigate';
  if (isPage || FILES.includes(path)) event.respondWith(fromCache(new URL(path || './', BASE).href, request));
});

/** An alert leads back to the panel. */
self.addEventListener('notificationclick', (event) => {
  event.notification.close();
  event.waitUntil(self.clients.matchAll({ type: 'window' }).then(([panel]) => panel?.focus()));
});

export {};
