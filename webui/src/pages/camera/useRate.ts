// SPDX-License-Identifier: Apache-2.0
// Measured image rate and bandwidth of a view.
import { computed } from 'vue';
import { now } from '../../state/live';
import type { Shown } from '../../picture/useLivePicture';

const WINDOW_MS = 2000;

export function useRate() {
  let pictures: { at: number; bytes: number }[] = [];
  const rate = computed(() => {
    pictures = pictures.filter(({ at }) => at > now.value - WINDOW_MS);
    const bytes = pictures.reduce((sum, picture) => sum + picture.bytes, 0);
    return { fps: pictures.length / (WINDOW_MS / 1000), mbitPerS: (bytes * 8) / 1e6 / (WINDOW_MS / 1000) };
  });
  return { rate, count: ({ at, bytes }: Shown) => { pictures.push({ at, bytes }); } };
}
