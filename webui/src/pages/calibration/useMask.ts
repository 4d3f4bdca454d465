// SPDX-License-Identifier: Apache-2.0
// A camera's mask while it is edited: shown at once, saved when a move ends, and undone step by step.
import { computed, ref, shallowRef } from 'vue';
import { useSetting } from '../../settings/useSetting';
import { cameraIndex, newestStepAt, save, undoStep, useSettings, type Outcome } from '../../state/settings';
import { isEqual, type Json } from '../../settings/pointer';
import type { Point } from '../../geometry/cameraModel';
import { shifted, spliced, withCorner, withInserted, withoutCorner, type Kind, type Mask, type Polygon } from './polygon';

export interface Place {
  kind: Kind;
  index: number;
}

export const samePlace = (a: Place | null, b: Place | null) => a?.kind === b?.kind && a?.index === b?.index;

export function useMask(camera: number) {
  const { settings, loadError } = useSettings();
  const setting = useSetting(() => `/cameras/${cameraIndex(camera)}/mask`);
  const saved = computed(() => (setting.saved.value ?? { include: [], exclude: [] }) as unknown as Mask);
  /** Set while a corner is dragged, and until the change is saved. */
  const draft = shallowRef<Mask | null>(null);
  const mask = computed(() => draft.value ?? saved.value);
  const selected = ref<Place | null>(null);
  /** Revisions of the settings made here, newest last. */
  const steps = ref<number[]>([]);
  /** Number of saves without an answer yet. */
  const pending = ref(0);

  const polygonAt = ({ kind, index }: Place): Polygon | undefined => mask.value[kind][index];
  const replaced = ({ kind, index }: Place, ...by: Polygon[]): Mask => ({ ...mask.value, [kind]: spliced(mask.value[kind], index, 1, ...by) });

  /** The saved mask when a drag began. */
  let began: Mask | null = null;
  const isGoingOnFrom = (mask: Mask) => began === mask;
  function drag(next: Mask): void {
    began ??= saved.value;
    draft.value = next;
  }
  /** Saves `next`, by default the mask shown. Writes only the lists that it changes, so that other changes are kept. */
  async function commit(next: Mask | null = draft.value): Promise<void> {
    if (!next) return;
    const from = began ?? saved.value;
    began = null;
    draft.value = next;
    const is = (kind: Kind, one: Mask, other: Mask) => isEqual(one[kind] as unknown as Json, other[kind] as unknown as Json);
    const changed = (['include', 'exclude'] as const).filter((kind) => !is(kind, next, from));
    const path = (kind: Kind) => `/cameras/${cameraIndex(camera)}/mask/${kind}`;
    const overtaken = changed.find((kind) => !is(kind, saved.value, from));
    const step = overtaken && await newestStepAt(path(overtaken));
    pending.value++;
    const outcome: Outcome = step ? { kind: 'stale', step }
      : await save(changed.map((kind) => ({ op: 'replace' as const, path: path(kind), value: next[kind] as unknown as Json })));
    pending.value--;
    setting.show(outcome);
    if (outcome.kind !== 'saved') return;
    if (draft.value === next) draft.value = null;
    // A drag that began meanwhile continues from the saved mask.
    if (isGoingOnFrom(from)) began = { ...from, ...Object.fromEntries(changed.map((kind) => [kind, next[kind]])) };
    if (outcome.revision !== undefined) steps.value.push(outcome.revision);
  }
  function giveUp(): void {
    began = null;
    draft.value = null;
    selected.value = null;
    setting.keepTheirs();
    setting.discard();
  }

  return {
    mask, selected, polygonAt,
    loaded: computed(() => settings.value !== null),
    loadError,
    error: setting.error, stale: setting.stale,
    keepTheirs: giveUp,
    useMine: () => (draft.value ? commit() : giveUp()),
    canUndo: computed(() => pending.value === 0 && (draft.value !== null || steps.value.length > 0)),
    /** Discards an unsaved change first. */
    async undo(): Promise<void> {
      if (pending.value) return;
      if (draft.value) return giveUp();
      const last = steps.value.at(-1);
      if (last === undefined) return;
      selected.value = null;
      pending.value++;
      const outcome = await undoStep(last);
      pending.value--;
      setting.show(outcome);
      if (outcome.kind === 'saved' || outcome.kind === 'stale') steps.value.pop();
    },
    moveCorner(place: Place, corner: number, to: Point) {
      const polygon = polygonAt(place);
      if (polygon) drag(replaced(place, withCorner(polygon, corner, to)));
    },
    shift(place: Place, from: Polygon, dx: number, dy: number) { drag(replaced(place, shifted(from, dx, dy))); },
    commit,
    add(kind: Kind, polygon: Polygon): Promise<void> {
      selected.value = { kind, index: mask.value[kind].length };
      return commit({ ...mask.value, [kind]: [...mask.value[kind], polygon] });
    },
    insert(place: Place, corner: number, at: Point) {
      const polygon = polygonAt(place);
      if (polygon) return commit(replaced(place, withInserted(polygon, corner, at)));
    },
    removeCorner(place: Place, corner: number) {
      const polygon = polygonAt(place);
      const next = polygon && withoutCorner(polygon, corner);
      if (next && next !== polygon) return commit(replaced(place, next));
    },
    remove(place: Place) {
      selected.value = null;
      return commit(replaced(place));
    },
    /** Changes a polygon from include to exclude, or back. */
    turnOver(place: Place) {
      const polygon = polygonAt(place)!;
      const kind: Kind = place.kind === 'include' ? 'exclude' : 'include';
      const without = replaced(place);
      selected.value = { kind, index: without[kind].length };
      return commit({ ...without, [kind]: [...without[kind], polygon] });
    },
  };
}
