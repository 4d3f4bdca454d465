// SPDX-License-Identifier: Apache-2.0
// One setting's value, from a control to the disk.
import { computed, ref, shallowRef, watch, type ShallowRef } from 'vue';
import type { SettingsStep } from '../api/types';
import { newestStepAt, saveValue, schema, settings, type Outcome } from '../state/settings';
import { isEqual, valueAt, type Json } from './pointer';
import { nodeAt, valueOr } from './schema';

interface Draft {
  value: Json;
}

export function useSetting(pointer: () => string) {
  const node = computed(() => (schema.value && settings.value !== null ? nodeAt(schema.value, settings.value, pointer()) : undefined));
  /** The service's value. A parameter missing in the tree has its default. */
  const saved = computed<Json | undefined>(() => valueOr(node.value, valueAt(settings.value ?? undefined, pointer())));
  /** Shown while it differs from `saved`: not saved yet, or invalid. */
  const draft: ShallowRef<Draft | null> = shallowRef(null);
  const value = computed(() => (draft.value ? draft.value.value : saved.value));
  const isDefault = computed(() => node.value?.default === undefined || isEqual(saved.value, node.value.default));

  const error = ref('');
  const stale = shallowRef<SettingsStep | null>(null);

  /** The service's value when typing began. */
  let base: Json | undefined;
  /** The last input was not a valid value. */
  let isRefused = false;

  watch(pointer, () => { draft.value = null; error.value = ''; stale.value = null; base = undefined; });

  function show(outcome: Outcome): void {
    error.value = outcome.kind === 'refused' || outcome.kind === 'failed' ? outcome.text : '';
    stale.value = outcome.kind === 'stale' ? outcome.step : null;
  }

  /** `joins`: see saveValue(). Returns the outcome; null if nothing was sent. */
  async function set(next: Json, joins = false): Promise<Outcome | null> {
    if (!draft.value && isEqual(next, saved.value)) { error.value = ''; return null; }
    const sent: Draft = { value: next };
    isRefused = false;
    draft.value = sent;
    const path = pointer();
    const somebodyElse = base !== undefined && !isEqual(base, saved.value) && !isEqual(next, saved.value);
    base = undefined;
    if (somebodyElse) {
      stale.value = await newestStepAt(path);
      if (stale.value) return null;
    }
    const outcome = await saveValue(path, next, joins);
    const isNewest = draft.value === sent && path === pointer();
    if (!isNewest) return outcome; // a newer value is pending
    const typedSince = isRefused ? error.value : null;
    show(outcome);
    if (typedSince !== null) error.value = typedSince;
    if (outcome.kind === 'saved') draft.value = null;
    return outcome;
  }

  return {
    node, saved, value, isDefault, error, stale,
    /** Typing begins: values that others save from now on are not overwritten without asking. */
    begin() { base = saved.value; },
    set,
    /** Shows the outcome of a change of this value that was made in another way. */
    show,
    reset: () => set(node.value!.default!),
    /** After a conflict: keepTheirs() keeps the other user's value, useMine() saves ours over it. */
    keepTheirs() { draft.value = null; stale.value = null; },
    useMine: () => (draft.value ? set(draft.value.value) : Promise.resolve(null)),
    /** The input is not a valid value: the field keeps it, and the service keeps the old value. */
    refuse(text: string) {
      isRefused = true;
      error.value = text;
    },
    discard() { draft.value = null; error.value = ''; stale.value = null; },
  };
}
