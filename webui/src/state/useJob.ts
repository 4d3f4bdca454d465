// SPDX-License-Identifier: Apache-2.0
// A job that takes the service a while (a calibration, learning colours): its state, polled, and its commands.
import { computed, onUnmounted, ref, shallowRef } from 'vue';
import { api, messageOf } from '../api/client';
import { showSaving } from './settings';

const RUNNING_MS = 500;
const IDLE_MS = 2000;

/** `path` is the part after "api/". */
export function useJob<State extends { state: string }>(path: string) {
  const state = shallowRef<State | null>(null);
  /** Why the state is unknown. */
  const problem = ref('');
  const running = computed(() => state.value?.state === 'collecting' || state.value?.state === 'solving');
  let timer: ReturnType<typeof setTimeout> | undefined;
  // Answers overtaken by a later request are ignored.
  let newest = 0;
  let alive = true;

  function wait(): void {
    clearTimeout(timer);
    if (alive) timer = setTimeout(() => void refresh(), running.value ? RUNNING_MS : IDLE_MS);
  }

  async function refresh(): Promise<void> {
    const mine = ++newest;
    try {
      const answer = await api.get<State>(path);
      if (mine !== newest) return;
      state.value = answer;
      problem.value = '';
    } catch (error) {
      if (mine === newest) problem.value = messageOf(error);
    }
    if (mine === newest) wait();
  }

  /** Throws ApiError. */
  async function ask(work: () => Promise<State>): Promise<void> {
    newest++;
    clearTimeout(timer);
    try {
      state.value = await work();
    } finally {
      newest++;
      wait();
    }
  }

  void refresh();
  onUnmounted(() => { alive = false; newest++; clearTimeout(timer); });

  return {
    state, problem, running, ask, refresh,
    start: (request: object) => ask(() => api.post<State>(path, request)),
    cancel: () => ask(() => api.delete<State>(path)),
    accept: (force: boolean) => ask(() => showSaving(() => api.post<State>(`${path}/accept`, { force }))),
    reject: () => ask(() => api.post<State>(`${path}/reject`)),
    revert: (force: boolean) => ask(() => showSaving(() => api.post<State>(`${path}/revert`, { force }))),
  };
}
