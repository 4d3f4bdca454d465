// SPDX-License-Identifier: Apache-2.0
// What the service records, kept up to date, and what can be asked of it.
import { ref, shallowRef } from 'vue';
import { api } from '../../api/client';
import type { Recordings } from '../../api/types';
import { usePolling } from '../../state/usePolling';

const PERIOD_MS = 1500;

export const logPath = (name: string): string => `recordings/logs/${encodeURIComponent(name)}`;

/** The newest state. An answer counts unless something newer was asked since. */
export function newestState() {
  const state = shallowRef<Recordings | null>(null);
  let newest = 0;
  return {
    state,
    async look(ask: () => Promise<Recordings>): Promise<void> {
      const mine = ++newest;
      const answer = await ask();
      if (mine === newest) state.value = answer;
    },
  };
}

export function useRecordings() {
  const { state, look } = newestState();
  const isBusy = ref(false);
  const trouble = usePolling(async () => {
    // The answer to a change says it, too.
    if (!isBusy.value) await look(() => api.get<Recordings>('recordings'));
  }, PERIOD_MS);

  /** Throws ApiError. */
  async function change(ask: () => Promise<Recordings>): Promise<void> {
    isBusy.value = true;
    try {
      await look(ask);
      trouble.value = '';
    } finally {
      isBusy.value = false;
    }
  }

  return {
    state, trouble, isBusy,
    record: (name: string) => change(() => api.post<Recordings>('recordings/match-log', name ? { record: true, name } : { record: true })),
    stop: () => change(() => api.post<Recordings>('recordings/match-log', { record: false })),
    pin: (log: string, pinned: boolean) => change(() => api.patch<Recordings>(logPath(log), { pinned })),
    remove: (log: string) => change(() => api.delete<Recordings>(logPath(log))),
  };
}
export type RecordingsAccess = ReturnType<typeof useRecordings>;
