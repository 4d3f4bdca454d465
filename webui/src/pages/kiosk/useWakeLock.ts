// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted, ref, type Ref } from 'vue';

/**
 * Keeps the screen on while the page is there. Browsers allow it only over HTTPS or on the service's own computer;
 * what comes back says whether they did.
 */
export function useWakeLock(): Ref<boolean> {
  const isAwake = ref(false);
  let lock: WakeLockSentinel | null = null;
  let isOver = false;
  async function ask(): Promise<void> {
    if (document.hidden || isAwake.value || !('wakeLock' in navigator)) return;
    // Refused, say for an empty battery: the screen sleeps as it always did.
    const got = await navigator.wakeLock.request('screen').catch(() => null);
    if (isOver || !got) return void got?.release();
    lock = got;
    isAwake.value = true;
    // The browser takes it back whenever the page is hidden.
    got.addEventListener('release', () => { isAwake.value = false; });
  }
  const onVisible = () => void ask();
  onMounted(() => {
    void ask();
    document.addEventListener('visibilitychange', onVisible);
  });
  onUnmounted(() => {
    isOver = true;
    document.removeEventListener('visibilitychange', onVisible);
    void lock?.release();
  });
  return isAwake;
}
