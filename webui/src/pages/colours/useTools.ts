// SPDX-License-Identifier: Apache-2.0
// The selected tool and label, and which part of the table is shown.
import { computed, ref, shallowRef } from 'vue';
import type { ColorLabel } from '../../api/types';
import type { IconName } from '../../components/icons';
import type { Brush } from './brush';
import { choosable, palette } from './labels';

export type Tool = 'pick' | 'box' | 'paint' | 'erase' | 'fill';
export type WholeOp = 'grow' | 'shrink' | 'smooth';
export const PICK_SIZES = [1, 3, 5, 9] as const;

/** Tools of the pointer. */
export const pointers: readonly { name: Tool; title: string; icon: IconName; key: string }[] = [
  { name: 'pick', title: 'Pick', icon: 'dropper', key: 'I' },
  { name: 'box', title: 'Box', icon: 'box', key: 'B' },
  { name: 'paint', title: 'Paint', icon: 'brush', key: 'P' },
  { name: 'erase', title: 'Erase', icon: 'erase', key: 'E' },
  { name: 'fill', title: 'Fill', icon: 'fill', key: 'G' },
];
/** Operations on all cells of a label. */
export const wholes: readonly { op: WholeOp; title: string; icon: IconName; key?: string }[] = [
  { op: 'grow', title: 'Grow', icon: 'grow', key: ']' },
  { op: 'shrink', title: 'Shrink', icon: 'shrink', key: '[' },
  { op: 'smooth', title: 'Smooth', icon: 'smooth' },
];

export function useTools(all: () => readonly ColorLabel[]) {
  const tool = ref<Tool>('pick');
  const labels = computed(() => choosable(all()));
  const chosenName = ref('');
  const chosen = computed(() => labels.value.find(({ name }) => name === chosenName.value) ?? labels.value[0] ?? null);
  const hidden = shallowRef<ReadonlySet<number>>(new Set());
  /** Highlights only cells where two colours touch. */
  const showsConflicts = ref(false);
  const pickSize = ref<(typeof PICK_SIZES)[number]>(3);
  const brush = ref<Brush>({ shape: 'ball', size: 3, depth: 3, onlyClear: false });
  const y = ref(128);
  return {
    tool, labels, chosen, hidden, showsConflicts, pickSize, brush,
    /** The level of the slice. */
    y,
    colours: computed(() => palette(all(), hidden.value)),
    use(next: Tool) { tool.value = next; },
    toggleConflicts() { showsConflicts.value = !showsConflicts.value; },
    choose(name: string) { chosenName.value = name; },
    toggle({ value }: ColorLabel) {
      const next = new Set(hidden.value);
      if (!next.delete(value)) next.add(value);
      hidden.value = next;
    },
    named: (value: number) => all().find((one) => one.value === value) ?? null,
  };
}
export type Tools = ReturnType<typeof useTools>;
