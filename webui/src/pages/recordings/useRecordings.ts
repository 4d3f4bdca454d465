// SPDX-License-Identifier: Apache-2.0
// The service's recordings, polled, with the commands for them.
import { ref, shallowRef } from 'vue';
import { api } from '../../api/client';
import type { Recordings } from '../../api/types';
import { usePolling } from '../../state/usePolling';

const PERIOD_MS = 1500;

export const logPath = (name: string): string => `recordings/logs/${encodeURIComponent(name)}`;

/** The newest state. Answers overtaken by a later request are ignored. */
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
    // The answer to a pending change contains the state, too.
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
