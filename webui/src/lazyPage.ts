// SPDX-License-Identifier: Apache-2.0
// A page that is loaded when it is opened. If the service is unreachable, it waits and then loads automatically.
import { defineAsyncComponent, type Component } from 'vue';
import { page } from './router';
import PageLoading from './shell/PageLoading.vue';
import { isOutdated, loadNewPanel, lookForPanel } from './state/panelVersion';

const AGAIN_MS = 1500;
const RELOAD_KEY = 'reloaded-page-at';
const RELOAD_EVERY_MS = 30_000;

const nextTry = () => new Promise<void>((resolve) => {
  const listening = new AbortController();
  const end = () => {
    listening.abort();
    clearTimeout(timer);
    resolve();
  };
  const timer = setTimeout(end, AGAIN_MS);
  addEventListener('online', end, { signal: listening.signal });
});

/** For a failed style sheet, browsers have no `sheet`, or one whose rules cannot be read. */
function hasFailed({ sheet }: HTMLLinkElement): boolean {
  try {
    return !sheet?.cssRules;
  } catch {
    return true;
  }
}

/** Reloads failed style sheets, which the import does not request again. */
async function loadStylesAgain(): Promise<void> {
  const failed = [...document.querySelectorAll<HTMLLinkElement>('link[rel="stylesheet"]')].filter(hasFailed);
  await Promise.all(failed.map((old) => new Promise<void>((resolve) => {
    const next = old.cloneNode() as HTMLLinkElement;
    next.onload = next.onerror = () => resolve();
    old.replaceWith(next);
  })));
}

/** A browser may remember that a script failed to load; only reloading the page clears that. */
function reload(): void {
  try {
    if (Date.now() - Number(sessionStorage.getItem(RELOAD_KEY) ?? 0) < RELOAD_EVERY_MS) return;
    sessionStorage.setItem(RELOAD_KEY, String(Date.now()));
  } catch {
    return;
  }
  location.reload();
}

export function lazyPage(load: () => Promise<Component>): Component {
  let openedOn = '';
  return defineAsyncComponent({
    loader() {
      openedOn = page.value.name;
      return load();
    },
    loadingComponent: PageLoading,
    delay: 150,
    async onError(_error, retry, fail, attempts) {
      const isLeft = () => page.value.name !== openedOn;
      while (!isLeft() && !await lookForPanel()) await nextTry();
      if (!isLeft() && isOutdated.value && await loadNewPanel(false, () => !isLeft())) return;
      // The next visit starts over.
      if (isLeft()) return fail();
      if (attempts > 1) reload();
      await loadStylesAgain();
      if (attempts > 1) await nextTry();
      retry();
    },
  });
}
