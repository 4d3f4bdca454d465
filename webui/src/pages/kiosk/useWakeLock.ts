// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted, ref, type Ref } from 'vue';

/**
 * Keeps the screen on while the page is open. Browsers allow it only over HTTPS or on the service's own computer.
 * Returns whether it is active.
 */
export function useWakeLock(): Ref<boolean> {
  const isAwake = ref(false);
  let lock: WakeLockSentinel | null = null;
  let isOver = false;
  async function ask(): Promise<void> {
    if (document.hidden || isAwake.value || !('wakeLock' in navigator)) return;
    // Refused, for example because the battery is empty: the screen sleeps as usual.
    const got = await navigator.wakeLock.request('screen').catch(() => null);
    if (isOver || !got) return void got?.release();
    lock = got;
    isAwake.value = true;
    // The browser releases the lock whenever the page is hidden.
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
