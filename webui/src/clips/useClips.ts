// SPDX-License-Identifier: Apache-2.0
// The last seconds in memory and their clips, polled, with the commands for them.
import { computed, ref, shallowRef } from 'vue';
import { api, ApiError, messageOf } from '../api/client';
import type { Clips } from '../api/types';
import { usePolling } from '../state/usePolling';
import { clipPath } from './paths';

/** Polling interval while a clip is written, because the user is waiting for it. */
const WRITING_MS = 400;

export interface KeepRequest {
  seconds?: number;
  seconds_after?: number;
  name?: string;
}

/** Polls every `period_ms`. */
export function useClips(period_ms: number) {
  const state = shallowRef<Clips | null>(null);
  const isBusy = ref(false);
  /** The service is too old to keep last seconds. */
  const isUnknown = ref(false);
  let newest = 0;
  async function look(ask: () => Promise<Clips>): Promise<Clips> {
    const mine = ++newest;
    const answer = await ask();
    if (mine === newest) state.value = answer;
    return answer;
  }
  const ask = () => look(() => api.get<Clips>('recordings/clips'));
  let lastAt = -Infinity;
  /** Error of the last request, kept until the next answer. */
  let wrong: unknown = null;
  const trouble = usePolling(async () => {
    const isDue = performance.now() - lastAt > period_ms - WRITING_MS / 2;
    if (!isBusy.value && !isUnknown.value && (isDue || state.value?.clip.state === 'writing')) {
      lastAt = performance.now();
      try {
        await ask();
        wrong = null;
      } catch (error) {
        if (error instanceof ApiError && error.status === 404) isUnknown.value = true;
        wrong = error;
      }
    }
    if (wrong) throw wrong;
  }, WRITING_MS);

  /** Throws ApiError. */
  async function change(request: () => Promise<Clips>): Promise<void> {
    isBusy.value = true;
    try {
      await look(request);
      wrong = null;
      trouble.value = '';
    } finally {
      isBusy.value = false;
    }
  }
  return {
    state, trouble, isBusy, isUnknown,
    isWriting: computed(() => state.value?.clip.state === 'writing'),
    keep: (request: KeepRequest) => change(() => api.post<Clips>('recordings/clips', request)),
    pin: (name: string, pinned: boolean) => change(() => api.patch<Clips>(clipPath(name), { pinned })),
    remove: (name: string) => change(() => api.delete<Clips>(clipPath(name))),
  };
}
export type ClipsAccess = ReturnType<typeof useClips>;

const LOOK_MS = 300;
const pause = (ms: number) => new Promise<void>((resolve) => { setTimeout(resolve, ms); });

/** Keeps a clip and waits until it is written. */
export function useKeeping() {
  /** Images written so far; null: no clip is being kept. */
  const written = ref<number | null>(null);
  const error = ref('');
  return {
    written, error,
    /** Returns the clip's name; null: it failed, and `error` says why. */
    async keep(request: KeepRequest): Promise<string | null> {
      if (written.value !== null) return null;
      error.value = '';
      written.value = 0;
      try {
        let { clip } = await api.post<Clips>('recordings/clips', request);
        // Until the service starts writing, the name is that of the previous clip.
        while (clip.state === 'writing') {
          written.value = clip.frames;
          await pause(LOOK_MS);
          clip = (await api.get<Clips>('recordings/clips').catch((reason) => {
            // The link may fail for a moment; the clip is still being written.
            if (reason instanceof ApiError && reason.status === 0) return { clip };
            throw reason;
          })).clip;
        }
        if (clip.state !== 'failed') return clip.name;
        error.value = `The clip could not be kept: ${clip.error || 'the service gave no reason'}`;
      } catch (reason) {
        error.value = messageOf(reason);
      } finally {
        written.value = null;
      }
      return null;
    },
  };
}
