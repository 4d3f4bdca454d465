// SPDX-License-Identifier: Apache-2.0
import { computed, type Ref } from 'vue';
import type { CameraStatus } from '../api/types';
import { ageOf, isStale, now, silentSeconds } from '../state/live';
import { pictureTrouble } from './trouble';
import type { Shown } from './useLivePicture';

export function usePictureTrouble(camera: () => CameraStatus, shown: Ref<Shown | null>) {
  return computed(() => {
    void now.value;
    const { state, error } = camera();
    return pictureTrouble({
      state,
      error,
      silentSeconds: isStale.value ? silentSeconds.value : null,
      age: shown.value ? ageOf(shown.value.header.t_capture) : null,
    });
  });
}
