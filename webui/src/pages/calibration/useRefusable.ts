// SPDX-License-Identifier: Apache-2.0
// Something the service may refuse unless it is forced: while the game runs (423), or because it is not good (409).
import { ref, shallowRef } from 'vue';
import { ApiError, messageOf } from '../../api/client';

export interface Refusal {
  text: string;
  /** Does it all the same; null where that would not help. */
  force: (() => Promise<void>) | null;
  /** What that button says. */
  title: string;
}

export function useRefusable() {
  const busy = ref(false);
  const refusal = shallowRef<Refusal | null>(null);

  /** `title` says what forcing does. `canBeForced`: whether a 409 is lifted by force, too. True when it was done. */
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
