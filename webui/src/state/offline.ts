// SPDX-License-Identifier: Apache-2.0
// Lets the browser cache the panel's files, once the panel works. Browsers do so only over HTTPS and on the service's
// own computer; elsewhere, or without disk space, nothing changes.
import { watch } from 'vue';
import { isLinkSlow, liveStatus } from './live';

/** The first images load before this; a slow link needs more time for them. */
const AFTER_MS = 4000;
const AFTER_SLOW_MS = 20_000;

export function keepPanel(): void {
  const container = navigator.serviceWorker as ServiceWorkerContainer | undefined;
  if (!container || !import.meta.env.PROD) return;
  let worksSince: number | null = null;
  const stop = watch(liveStatus, (status) => {
    if (!status) return;
    worksSince ??= performance.now();
    if (performance.now() - worksSince < (isLinkSlow.value ? AFTER_SLOW_MS : AFTER_MS)) return;
    stop();
    container.register('sw.js', { updateViaCache: 'none' }).catch(() => {});
  });
}
