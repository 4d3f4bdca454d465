// SPDX-License-Identifier: Apache-2.0
// Which picture and which overlays are on; kept while the panel is open, for all cameras.
import { computed, reactive, ref } from 'vue';
import type { Layers } from '../../picture/LivePicture.vue';

export const layers = reactive<Layers>({ detections: true, lines: true, grid: false, labels: false });
export const allHidden = ref(false);

const NONE: Layers = { detections: false, lines: false, grid: false, labels: false };
export const shownLayers = computed(() => (allHidden.value ? NONE : layers));

export const layerList: { name: keyof Layers; title: string; key: string }[] = [
  { name: 'detections', title: 'Detections', key: '1' },
  { name: 'lines', title: 'Field lines', key: '2' },
  { name: 'grid', title: 'Grid, 1 m', key: '3' },
  { name: 'labels', title: 'Colour labels', key: '4' },
];

export function toggleLayer(name: keyof Layers): void {
  layers[name] = allHidden.value || !layers[name];
  allHidden.value = false;
}
