// SPDX-License-Identifier: Apache-2.0
import { computed, type Ref } from 'vue';
import type { CameraStatus } from '../api/types';
import { ageOf, imageGapAtService, isLinkSlow, isStale, now, silentSeconds } from '../state/live';
import { pictureTrouble } from './trouble';
import type { Shown } from './useLivePicture';

export function usePictureTrouble(camera: () => CameraStatus, shown: Ref<Shown | null>) {
  return computed(() => {
    void now.value;
    const { id, state, error } = camera();
    return pictureTrouble({
      state,
      error,
      silentSeconds: isStale.value ? silentSeconds.value : null,
      isLinkSlow: isLinkSlow.value,
      gapAtService: imageGapAtService(id),
      age: shown.value ? ageOf(shown.value.header.t_capture) : null,
    });
  });
}
