// SPDX-License-Identifier: Apache-2.0
// The stack of a camera while it is rearranged: nothing is applied before the service confirms that it would run.
import { computed, reactive, ref, watch } from 'vue';
import { isEqual, valueAt } from '../../settings/pointer';
import { checkChange, save, schema, settings } from '../../state/settings';
import { refusal, saySaved } from './notice';
import { itemAt, itemsOf, namesOf, type StackItem } from './stack';

interface Draft {
  items: StackItem[];
  /** The stack from which it was derived. */
  base: string[];
}
/** By camera id, so that viewing a stage's settings does not discard the draft. */
const drafts = reactive(new Map<number, Draft>());

export function useStack(camera: () => number) {
  const pointer = computed(() => `/cameras/${camera()}/stack`);
  const node = computed(() => schema.value?.properties?.cameras?.items?.properties?.stack);
  const id = computed(() => Number(valueAt(settings.value!, `/cameras/${camera()}/id`)));
  const inForce = computed(() => {
    const stack = valueAt(settings.value!, pointer.value);
    return Array.isArray(stack) ? stack.map(String) : [];
  });
  const usual = computed(() => (Array.isArray(node.value?.default) ? node.value.default.map(String) : []));
  const known = computed(() => (node.value?.items?.enum ?? []).map(String));
  const draft = computed(() => {
    const one = drafts.get(id.value);
    // A draft without changes only contains the positions of inactive stages.
    const isIdle = one && isEqual(namesOf(one.items), one.base) && !isEqual(one.base, inForce.value);
    return isIdle ? undefined : one;
  });
  const items = computed<StackItem[]>({
    get: () => draft.value?.items ?? itemsOf(inForce.value, usual.value),
    set: (list) => { drafts.set(id.value, { items: list, base: draft.value?.base ?? inForce.value }); },
  });
  const names = computed(() => namesOf(items.value));
  const isChanged = computed(() => !isEqual(names.value, inForce.value));

  /** Another user changed the stack since. */
  const isStale = computed(() => isChanged.value && draft.value !== undefined && !isEqual(draft.value.base, inForce.value));

  type Check = { kind: 'none' } | { kind: 'checking' } | { kind: 'fine' } | { kind: 'refused'; text: string; item: number | null };
  const check = ref<Check>({ kind: 'none' });
  let asked = 0;
  watch([names, inForce, id], async () => {
    const mine = ++asked;
    if (!isChanged.value) { check.value = { kind: 'none' }; return; }
    check.value = { kind: 'checking' };
    const list = items.value;
    const answer = await checkChange([{ op: 'replace', path: pointer.value, value: namesOf(list) }]);
    if (mine !== asked) return; // rearranged meanwhile
    check.value = 'error' in answer ? { kind: 'refused', text: answer.error, item: itemAt(list, answer.error) } : { kind: 'fine' };
  }, { immediate: true });

  return {
    items, inForce, known, isChanged, isStale, check,
    discard: () => { drafts.delete(id.value); },
    async apply(): Promise<void> {
      const list = items.value;
      const of = id.value;
      const outcome = await save([{ op: 'replace', path: pointer.value, value: namesOf(list) }]);
      const text = refusal(outcome);
      if (text) check.value = { kind: 'refused', text, item: itemAt(list, text) };
      // Changes made meanwhile are kept.
      else drafts.set(of, { items: drafts.get(of)?.items ?? list, base: namesOf(list) });
      if (!text) saySaved(outcome, `Camera ${of} runs: ${namesOf(list).join(', ') || 'no stage'}`);
    },
  };
}
