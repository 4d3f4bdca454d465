// SPDX-License-Identifier: Apache-2.0
// Whether the service has another panel than this one, as after an upgrade; then this one loads it as soon as nothing can
// be lost by that.
import { ref, watch } from 'vue';
import { CACHE_PREFIX } from '../cachePrefix';
import { page } from '../router';
import { isOpen } from './live';

/** The service has another panel. */
export const isOutdated = ref(false);

const KEY = 'reloaded-for';
const IDLE_MS = 10_000;
/** Over a slow link a service worker may take longer to have the new panel: who presses the button does not wait for it. */
const WORKER_MS = 20_000;
/** A worker says at once what it has. */
const ANSWER_MS = 2000;
const AT_ONCE_MS = 2000;
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

const pause = (ms: number) => new Promise<void>((resolve) => { setTimeout(resolve, ms); });

/**
 * Whether a reload gets the new panel from this worker. Only the worker itself can say so: the caches hold what the next
 * one has taken so far, too.
 */
const hasTheirs = (worker: ServiceWorker) => new Promise<boolean>((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = ({ data }) => resolve(data === true);
  void pause(ANSWER_MS).then(() => resolve(false));
  worker.postMessage(theirs, [port2]);
});

/** The worker answers with the files it has: it must have the new ones, or go. Says whether a reload gets them now. */
async function refreshWorker(isAsked: boolean): Promise<boolean> {
  const container = navigator.serviceWorker as ServiceWorkerContainer | undefined;
  const registration = await container?.getRegistration();
  if (!registration?.active) return true;
  const isComing = () => (registration.installing ?? registration.waiting) !== null;
  // While one is installed this waits for that.
  await Promise.race([registration.update().catch(() => {}), pause(WORKER_MS)]);
  for (const end = performance.now() + WORKER_MS; isComing() && performance.now() < end;) await pause(250);
  if (await hasTheirs(registration.active)) return true;
  if (isComing() && !isAsked) return false;
  // Without the worker only the service has a panel.
  if (!await lookForPanel()) return false;
  await registration.unregister();
  for (const name of await caches.keys()) if (name.startsWith(CACHE_PREFIX)) await caches.delete(name);
  return true;
}

let running: Promise<boolean> | null = null;
/** Whether a reload gets the new panel; prepares that as far as it goes. */
function prepare(isAsked: boolean): Promise<boolean> {
  if (isAsked) return refreshWorker(true).catch(() => true);
  running ??= refreshWorker(false).catch(() => true).finally(() => { running = null; });
  return running;
}

/**
 * For the button; automatically only once for each panel, whatever a proxy may keep, and if it still `may` once the new panel
 * is there. Says whether it is being loaded.
 */
export async function loadNewPanel(isAsked = true, may = () => true): Promise<boolean> {
  try {
    if (!isAsked && sessionStorage.getItem(KEY) === theirs) return false;
    if (!await prepare(isAsked) || !may()) return false;
    if (!isAsked) sessionStorage.setItem(KEY, theirs);
  } catch {
    return false; // without storage it could go on for ever
  }
  location.reload();
  return true;
}

export function followPanelVersion(): void {
  let touchedAt = performance.now();
  for (const kind of ['pointerdown', 'pointermove', 'keydown', 'wheel'])
    addEventListener(kind, () => { touchedAt = performance.now(); }, { passive: true, capture: true });
  // After each loss of the connection the service may be another one.
  watch(isOpen, (open) => { if (open) void lookForPanel(); });
  watch(page, () => {
    const changedAt = performance.now();
    // Later somebody may have begun something on this page.
    if (isOutdated.value) void loadNewPanel(false, () => performance.now() - changedAt < AT_ONCE_MS);
  });
  const isUnused = () => performance.now() - touchedAt >= IDLE_MS && PLAIN_PAGES.includes(page.value.name) && !document.querySelector('dialog[open]');
  setInterval(() => { if (isOutdated.value && isOpen.value && isUnused()) void loadNewPanel(false, isUnused); }, 1000);
}
