// SPDX-License-Identifier: Apache-2.0
// Detects that the service has another panel than this one, for example after an upgrade; the page then reloads as soon
// as a reload loses nothing.
import { ref, watch } from 'vue';
import { CACHE_PREFIX } from '../cachePrefix';
import { page } from '../router';
import { isOpen } from './live';

/** The service has another panel. */
export const isOutdated = ref(false);

const KEY = 'reloaded-for';
const IDLE_MS = 10_000;
/**
 * Maximum wait for a service worker to load the new panel. It may need longer on a slow link, but a user who presses the
 * button does not wait for it.
 */
const WORKER_MS = 20_000;
/** A worker answers at once which files it has. */
const ANSWER_MS = 2000;
const AT_ONCE_MS = 2000;
/** Pages without any input that a reload would lose. */
const PLAIN_PAGES = ['overview', 'field', 'diagnostics', 'kiosk', 'api'];

const entryOf = (html: string) => /<script[^>]*src="[^"]*?(assets\/[^"]+)"/.exec(html)?.[1] ?? null;
const own = document.querySelector<HTMLScriptElement>('script[type="module"]')?.src ?? '';
let theirs = '';

/** Whether the service answers with a panel at all; sets isOutdated if that is another one. */
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
 * Whether a reload gets the new panel from this worker. Only the worker itself knows: the caches also contain what the
 * next worker has loaded so far.
 */
const hasTheirs = (worker: ServiceWorker) => new Promise<boolean>((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = ({ data }) => resolve(data === true);
  void pause(ANSWER_MS).then(() => resolve(false));
  worker.postMessage(theirs, [port2]);
});

/**
 * The worker answers with its cached files: it must load the new ones, or be removed. Returns whether a reload gets
 * them now.
 */
async function refreshWorker(isAsked: boolean): Promise<boolean> {
  const container = navigator.serviceWorker as ServiceWorkerContainer | undefined;
  const registration = await container?.getRegistration();
  if (!registration?.active) return true;
  const isComing = () => (registration.installing ?? registration.waiting) !== null;
  // If one is being installed, this waits for it.
  await Promise.race([registration.update().catch(() => {}), pause(WORKER_MS)]);
  for (const end = performance.now() + WORKER_MS; isComing() && performance.now() < end;) await pause(250);
  if (await hasTheirs(registration.active)) return true;
  if (isComing() && !isAsked) return false;
  // Without the worker, only the service can deliver a panel.
  if (!await lookForPanel()) return false;
  await registration.unregister();
  for (const name of await caches.keys()) if (name.startsWith(CACHE_PREFIX)) await caches.delete(name);
  return true;
}

let running: Promise<boolean> | null = null;
/** Prepares a reload, and returns whether it would get the new panel. */
function prepare(isAsked: boolean): Promise<boolean> {
  if (isAsked) return refreshWorker(true).catch(() => true);
  running ??= refreshWorker(false).catch(() => true).finally(() => { running = null; });
  return running;
}

/**
 * For the button. Automatic calls reload only once per new panel, even if a proxy still serves the old one, and only if
 * `may` still allows it when the new panel is available. Returns whether the page reloads.
 */
export async function loadNewPanel(isAsked = true, may = () => true): Promise<boolean> {
  try {
    if (!isAsked && sessionStorage.getItem(KEY) === theirs) return false;
    if (!await prepare(isAsked) || !may()) return false;
    if (!isAsked) sessionStorage.setItem(KEY, theirs);
  } catch {
    return false; // without storage this could loop forever
  }
  location.reload();
  return true;
}

export function followPanelVersion(): void {
  let touchedAt = performance.now();
  for (const kind of ['pointerdown', 'pointermove', 'keydown', 'wheel'])
    addEventListener(kind, () => { touchedAt = performance.now(); }, { passive: true, capture: true });
  // After each reconnect, the service may have another panel.
  watch(isOpen, (open) => { if (open) void lookForPanel(); });
  watch(page, () => {
    const changedAt = performance.now();
    // Later, a reload could lose something that the user has begun on this page.
    if (isOutdated.value) void loadNewPanel(false, () => performance.now() - changedAt < AT_ONCE_MS);
  });
  const isUnused = () => performance.now() - touchedAt >= IDLE_MS && PLAIN_PAGES.includes(page.value.name) && !document.querySelector('dialog[open]');
  setInterval(() => { if (isOutdated.value && isOpen.value && isUnused()) void loadNewPanel(false, isUnused); }, 1000);
}
