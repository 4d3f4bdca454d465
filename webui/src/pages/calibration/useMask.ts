// SPDX-License-Identifier: Apache-2.0
// A camera's mask while it is being drawn: shown at once, saved when a move is over, and taken back step by step.
import { computed, ref, shallowRef } from 'vue';
import { useSetting } from '../../settings/useSetting';
import { cameraIndex, useSettings } from '../../state/settings';
import type { Json } from '../../settings/pointer';
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
  const saved = computed(() => (setting.value.value ?? { include: [], exclude: [] }) as unknown as Mask);
  /** While a corner is dragged. */
  const draft = shallowRef<Mask | null>(null);
  const mask = computed(() => draft.value ?? saved.value);
  const selected = ref<Place | null>(null);
  const before = ref<Mask[]>([]);

  const polygonAt = ({ kind, index }: Place): Polygon | undefined => mask.value[kind][index];
  const replaced = ({ kind, index }: Place, ...by: Polygon[]): Mask => ({ ...mask.value, [kind]: spliced(mask.value[kind], index, 1, ...by) });

  async function put(next: Mask): Promise<void> {
    await setting.set(next as unknown as Json);
  }
  /** Saves what is shown; `next` if something else. */
  async function commit(next: Mask | null = draft.value): Promise<void> {
    if (!next) return;
    before.value.push(saved.value);
    draft.value = null;
    await put(next);
  }

  return {
    mask, selected, polygonAt,
    loaded: computed(() => settings.value !== null),
    loadError,
    error: setting.error, stale: setting.stale, keepTheirs: setting.keepTheirs, useMine: setting.useMine,
    canUndo: computed(() => before.value.length > 0),
    async undo(): Promise<void> {
      const last = before.value.pop();
      if (!last) return;
      selected.value = null;
      draft.value = null;
      await put(last);
    },
    moveCorner(place: Place, corner: number, to: Point) {
      const polygon = polygonAt(place);
      if (polygon) draft.value = replaced(place, withCorner(polygon, corner, to));
    },
    shift(place: Place, from: Polygon, dx: number, dy: number) { draft.value = replaced(place, shifted(from, dx, dy)); },
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
    /** From include to exclude, or back. */
    turnOver(place: Place) {
      const polygon = polygonAt(place)!;
      const kind: Kind = place.kind === 'include' ? 'exclude' : 'include';
      const without = replaced(place);
      selected.value = { kind, index: without[kind].length };
      return commit({ ...without, [kind]: [...without[kind], polygon] });
    },
  };
}
