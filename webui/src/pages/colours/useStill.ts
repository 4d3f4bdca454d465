// SPDX-License-Identifier: Apache-2.0
// An image frozen on the service, and its labels by the table.
import { onUnmounted, ref, shallowRef } from 'vue';
import { api, ApiError, messageOf } from '../../api/client';
import type { Still } from '../../api/types';
import { decodeLabelPicture, type LabelPicture } from './runs';

/** Wider images are scaled down: the magnifier shows raw pixels anyway. */
const MOST_WIDTH = 2048;

export function useStill(camera: number) {
  const still = shallowRef<Still | null>(null);
  const picture = shallowRef<ImageBitmap | null>(null);
  const labels = shallowRef<LabelPicture | null>(null);
  const problem = ref('');
  const busy = ref(false);
  let alive = true;

  function forget(): void {
    still.value = null;
    picture.value?.close();
    picture.value = null;
    labels.value = null;
  }

  async function freeze(): Promise<void> {
    if (busy.value) return;
    busy.value = true;
    problem.value = '';
    try {
      const taken = await api.post<Still>(`cameras/${camera}/stills`);
      const path = `cameras/${camera}/stills/${taken.still}`;
      const width = taken.width > MOST_WIDTH ? `&width=${MOST_WIDTH}` : '';
      const [jpeg, made] = await Promise.all([
        api.blob(`${path}/picture.jpg?quality=92${width}`).then((blob) => createImageBitmap(blob)),
        api.blob(`${path}/labels`).then((blob) => blob.arrayBuffer()).then(decodeLabelPicture),
      ]);
      if (!alive) { jpeg.close(); return; }
      forget();
      picture.value = jpeg;
      labels.value = made;
      still.value = taken;
    } catch (error) {
      problem.value = `Not frozen: ${messageOf(error)}`;
    } finally {
      busy.value = false;
    }
  }

  let looking = false;
  let again = false;
  /** Reloads the labels after an edit. */
  async function refresh(): Promise<void> {
    if (looking) { again = true; return; }
    looking = true;
    do {
      again = false;
      const current = still.value;
      if (!current) break;
      try {
        const made = decodeLabelPicture(await (await api.blob(`cameras/${camera}/stills/${current.still}/labels`)).arrayBuffer());
        if (still.value === current) labels.value = made;
      } catch (error) {
        if (still.value !== current) break;
        // The service does not keep it forever.
        if (error instanceof ApiError && error.status === 404) forget();
        problem.value = error instanceof ApiError && error.status === 404 ? 'The service no longer has the frozen image. Freeze another one.' : messageOf(error);
      }
    } while (again);
    looking = false;
  }

  onUnmounted(() => { alive = false; forget(); });
  return { still, picture, labels, problem, busy, freeze, unfreeze: forget, refresh };
}
export type Frozen = ReturnType<typeof useStill>;
