// SPDX-License-Identifier: Apache-2.0
// Image areas too far beyond the field for a camera to search: the service computes them, not the panel.
import { shallowRef, watch, type ShallowRef } from 'vue';
import { api } from '../api/client';
import type { FieldView } from '../api/types';
import type { Rectangle } from '../picture/mask';
import { revision } from './settings';

/** Reloaded whenever settings change. Empty while unknown. */
export function useFieldView(camera: () => number | undefined): Readonly<ShallowRef<Rectangle[]>> {
  const hidden = shallowRef<Rectangle[]>([]);
  watch([camera, revision], async ([id, asked], before) => {
    if (id !== before[0]) hidden.value = [];
    if (id === undefined) return;
    try {
      const view = await api.get<FieldView>(`cameras/${id}/field_view`);
      if (id === camera() && asked === revision.value) hidden.value = view.hidden as Rectangle[];
    } catch {
      // The connection indicator reports it; the next change requests it again.
    }
  }, { immediate: true });
  return hidden;
}
