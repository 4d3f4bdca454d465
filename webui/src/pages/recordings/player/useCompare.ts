// SPDX-License-Identifier: Apache-2.0
// The service's current or last comparison; the service runs one at a time.
import { computed, onUnmounted, ref, shallowRef } from 'vue';
import { api, messageOf } from '../../../api/client';
import type { Comparison, CompareWith } from '../../../api/types';
import { clipPath } from '../../../clips/paths';

const RUNNING_MS = 500;

export function useCompare(clip: string) {
  const comparison = shallowRef<Comparison | null>(null);
  const error = ref('');
  const isRunning = computed(() => comparison.value?.state === 'running');
  let timer = 0;
  let alive = true;

  async function look(): Promise<void> {
    try {
      const answer = await api.get<Comparison>('recordings/compare');
      if (!alive) return;
      comparison.value = answer;
    } catch {
      // A failing link also fails frames, which the page reports; a running comparison is polled again.
    }
    wait();
  }
  function wait(): void {
    clearTimeout(timer);
    if (alive && isRunning.value) timer = window.setTimeout(() => void look(), RUNNING_MS);
  }
  void look();
  onUnmounted(() => { alive = false; clearTimeout(timer); });

  return {
    comparison, error, isRunning,
    async start(camera: number, against: CompareWith): Promise<void> {
      error.value = '';
      try {
        comparison.value = await api.post<Comparison>(`${clipPath(clip)}/compare`, { camera, with: against });
      } catch (reason) {
        error.value = messageOf(reason);
      }
      wait();
    },
  };
}
export type CompareAccess = ReturnType<typeof useCompare>;
