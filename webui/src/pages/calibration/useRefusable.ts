// SPDX-License-Identifier: Apache-2.0
// A request that the service may refuse unless it is forced: during a match (423), or because the result is poor (409).
import { ref, shallowRef } from 'vue';
import { ApiError, messageOf } from '../../api/client';

export interface Refusal {
  text: string;
  /** Repeats the request with force; null if that would not help. */
  force: (() => Promise<void>) | null;
  /** Label of that button. */
  title: string;
}

export function useRefusable() {
  const busy = ref(false);
  const refusal = shallowRef<Refusal | null>(null);

  /**
   * `title`: label of the force button. `canBeForced`: whether force overrides a 409, too. Returns whether it
   * succeeded.
   */
  async function attempt(title: string, act: (force: boolean) => Promise<void>, canBeForced: () => boolean = () => false, force = false): Promise<boolean> {
    busy.value = true;
    refusal.value = null;
    try {
      await act(force);
      return true;
    } catch (error) {
      const status = error instanceof ApiError ? error.status : 0;
      const liftable = !force && (status === 423 || (status === 409 && canBeForced()));
      refusal.value = { text: messageOf(error), title, force: liftable ? async () => { await attempt(title, act, canBeForced, true); } : null };
      return false;
    } finally {
      busy.value = false;
    }
  }
  return { busy, refusal, attempt };
}
