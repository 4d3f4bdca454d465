// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted, ref, type Ref } from 'vue';
import { messageOf } from '../api/client';

const PERIOD_MS = 1000;

/**
 * Calls `ask` every `period_ms` while the page is open and visible, one call at a time. Returns the error of the last
 * call; empty: none.
 */
export function usePolling(ask: () => Promise<void>, period_ms = PERIOD_MS): Ref<string> {
  const trouble = ref('');
  let timer = 0;
  let isOver = false;
  async function round(): Promise<void> {
    if (!document.hidden) {
      try {
        await ask();
        trouble.value = '';
      } catch (error) {
        trouble.value = messageOf(error);
      }
    }
    if (!isOver) timer = window.setTimeout(() => void round(), period_ms);
  }
  onMounted(() => void round());
  onUnmounted(() => {
    isOver = true;
    clearTimeout(timer);
  });
  return trouble;
}
