// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted, ref, type Ref } from 'vue';
import { messageOf } from '../api/client';

const PERIOD_MS = 1000;

/**
 * Asks the service once a second, or as seldom as `period_ms` says, while the page is open and in sight, never twice at a time.
 * What comes back says what went wrong the last time; empty: nothing.
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
