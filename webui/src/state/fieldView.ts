// SPDX-License-Identifier: Apache-2.0
// What lies too far beyond the field for a camera to look at: the service knows, nothing here computes it again.
import { shallowRef, watch, type ShallowRef } from 'vue';
import { api } from '../api/client';
import type { FieldView } from '../api/types';
import type { Rectangle } from '../picture/mask';
import { revision } from './settings';

/** Loaded again whenever settings change. Empty while it is not known. */
export function useFieldView(camera: () => number | undefined): Readonly<ShallowRef<Rectangle[]>> {
  const hidden = shallowRef<Rectangle[]>([]);
  watch([camera, revision], async ([id, asked], before) => {
    if (id !== before[0]) hidden.value = [];
    if (id === undefined) return;
    try {
      const view = await api.get<FieldView>(`cameras/${id}/field_view`);
      if (id === camera() && asked === revision.value) hidden.value = view.hidden as Rectangle[];
    } catch {
      // The connection's own notice says so; the next change asks again.
    }
  }, { immediate: true });
  return hidden;
}
