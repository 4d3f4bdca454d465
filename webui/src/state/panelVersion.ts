// SPDX-License-Identifier: Apache-2.0
// Whether the service has another panel than this one, as after an upgrade; then this one loads it as soon as nothing can
// be lost by that.
import { ref, watch } from 'vue';
import { page } from '../router';
import { isOpen } from './live';

/** The service has another panel. */
export const isOutdated = ref(false);

const KEY = 'reloaded-for';
const IDLE_MS = 10_000;
/** A service worker that has not taken the new panel by then does not take it at all. */
const WORKER_MS = 20_000;
/** Pages that hold nothing but what the service knows, too. */
const PLAIN_PAGES = ['overview', 'field', 'diagnostics', 'kiosk', 'api'];

const entryOf = (html: string) => /<script[^>]*src="[^"]*?(assets\/[^"]+)"/.exec(html)?.[1] ?? null;
const own = document.querySelector<HTMLScriptElement>('script[type="module"]')?.src ?? '';
let theirs = '';

/** Whether the service answers with a panel at all; says so if it is another one. */
export async function lookForPanel(): Promise<boolean> {
  try {
    const answer = await fetch('./', { cache: 'no-store', signal: AbortSignal.timeout(10_000) });
    const entry = answer.ok ? entryOf(await answer.text()) : null;
    if (!entry) return false;
    theirs = entry;
    isOutdated.value = own.includes('assets/') && !own.endsWith(entry);
    return true;
  } catch {
    return false;
  }
}

/** The worker answers with the files it has: it must have the new ones, or go. */
async function refreshWorker(): Promise<void> {
  const container = navigator.serviceWorker as ServiceWorkerContainer | undefined;
  if (!container?.controller) return;
  const registration = await container.getRegistration();
  const taken = new Promise<void>((resolve) => {
    container.addEventListener('controllerchange', () => resolve(), { once: true });
    setTimeout(resolve, WORKER_MS);
  });
  await registration?.update().catch(() => {});
  if (registration?.installing || registration?.waiting) await taken;
  if (await workerHas(theirs)) return;
  await registration?.unregister();
  for (const name of await caches.keys()) await caches.delete(name);
}

const workerHas = async (entry: string) => (await caches.match(new URL(entry, document.baseURI).href)) !== undefined;

/** For the button; by itself only once for each panel, whatever a proxy may keep. */
export async function loadNewPanel(isAsked = true): Promise<void> {
  if (!isAsked) {
    try {
      if (sessionStorage.getItem(KEY) === theirs) return;
      sessionStorage.setItem(KEY, theirs);
    } catch {
      return; // it could go on for ever
    }
  }
  await refreshWorker().catch(() => {});
  location.reload();
}

export function followPanelVersion(): void {
  let touchedAt = performance.now();
  for (const kind of ['pointerdown', 'pointermove', 'keydown', 'wheel'])
    addEventListener(kind, () => { touchedAt = performance.now(); }, { passive: true, capture: true });
  // After each loss of the connection the service may be another one.
  watch(isOpen, (open) => { if (open) void lookForPanel(); });
  watch(page, () => { if (isOutdated.value) void loadNewPanel(false); });
  setInterval(() => {
    if (!isOutdated.value || performance.now() - touchedAt < IDLE_MS) return;
    if (PLAIN_PAGES.includes(page.value.name) && !document.querySelector('dialog[open]')) void loadNewPanel(false);
  }, 1000);
}
