// SPDX-License-Identifier: Apache-2.0
import { onMounted, watch } from 'vue';
import { isOpen } from '../../state/live';

/** The panel's own page: it names its scripts, so that a new panel has another one. Null: no answer. */
async function panelText(): Promise<string | null> {
  try {
    const answer = await fetch('./', { cache: 'no-store', signal: AbortSignal.timeout(15_000) });
    return answer.ok ? await answer.text() : null;
  } catch {
    return null;
  }
}

/** Loads the page again when a service that came back has another panel: nobody stands at a kiosk to press a key. */
export function useReload(): void {
  let first: string | null = null;
  async function look(): Promise<void> {
    const now = await panelText();
    if (now !== null && first !== null && now !== first) location.reload();
    first ??= now;
  }
  onMounted(() => void look());
  watch(isOpen, (open) => { if (open) void look(); });
}
