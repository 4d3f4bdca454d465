// SPDX-License-Identifier: Apache-2.0
// A page that loads when it is opened. Without the service it waits for it and then loads by itself.
import { defineAsyncComponent, type Component } from 'vue';
import PageLoading from './shell/PageLoading.vue';
import { isOutdated, loadNewPanel, lookForPanel } from './state/panelVersion';

const AGAIN_MS = 1500;
const RELOAD_KEY = 'reloaded-page-at';
const RELOAD_EVERY_MS = 30_000;

const nextTry = () => new Promise<void>((resolve) => {
  setTimeout(resolve, AGAIN_MS);
  addEventListener('online', () => resolve(), { once: true });
});

/** Of a sheet that did not come, browsers have none, or one that nobody may read. */
function hasFailed({ sheet }: HTMLLinkElement): boolean {
  try {
    return !sheet?.cssRules;
  } catch {
    return true;
  }
}

/** A style sheet that failed is not asked for again by the import. */
async function loadStylesAgain(): Promise<void> {
  const failed = [...document.querySelectorAll<HTMLLinkElement>('link[rel="stylesheet"]')].filter(hasFailed);
  await Promise.all(failed.map((old) => new Promise<void>((resolve) => {
    const next = old.cloneNode() as HTMLLinkElement;
    next.onload = next.onerror = () => resolve();
    old.replaceWith(next);
  })));
}

/** A browser may remember that a script could not be had; only the page's own reload has it forget that. */
function reload(): void {
  try {
    if (Date.now() - Number(sessionStorage.getItem(RELOAD_KEY) ?? 0) < RELOAD_EVERY_MS) return;
    sessionStorage.setItem(RELOAD_KEY, String(Date.now()));
  } catch {
    return;
  }
  location.reload();
}

export const lazyPage = (load: () => Promise<Component>): Component => defineAsyncComponent({
  loader: load,
  loadingComponent: PageLoading,
  delay: 150,
  async onError(_error, retry, _fail, attempts) {
    while (!await lookForPanel()) await nextTry();
    if (isOutdated.value) return void loadNewPanel(false);
    if (attempts > 1) reload();
    await loadStylesAgain();
    if (attempts > 1) await nextTry();
    retry();
  },
});
