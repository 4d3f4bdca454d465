// SPDX-License-Identifier: Apache-2.0
// Which image and which overlays are shown, for all cameras; the choice is stored in the browser.
import { computed, reactive, ref, watch } from 'vue';
import type { Layers } from '../../picture/LivePicture.vue';

export interface Layer {
  name: keyof Layers;
  title: string;
  key: string;
  /** What the layer shows. */
  what: string;
  /** Default for the first visit. */
  isOn: boolean;
}

export const layerList: readonly Layer[] = [
  { name: 'detections', title: 'Detections', key: '1', isOn: true, what: 'Robots with their heading, and balls, as found in this frame.' },
  { name: 'lines', title: 'Field lines', key: '2', isOn: true, what: 'The field lines as the calibration projects them. They should cover the painted lines.' },
  { name: 'regions', title: 'Regions', key: '3', isOn: false, what: 'Connected pixels of one label, each in its label’s colour; the largest 500.' },
  { name: 'mask', title: 'Mask', key: '4', isOn: true, what: 'Hatched: not searched, because the mask hides it or it lies too far beyond the field.' },
  { name: 'over', title: 'Over-exposed', key: '5', isOn: false, what: 'Pixels of the shown image with red, green or blue at 250 or more of 255: their colour is lost.' },
  { name: 'under', title: 'Under-exposed', key: '6', isOn: false, what: 'Pixels of the shown image with red, green and blue at 6 or less of 255.' },
  { name: 'labels', title: 'Labels', key: '7', isOn: false, what: 'The label that the colour table gives each pixel, instead of the camera’s image.' },
  { name: 'grid', title: 'Grid, 1 m', key: '8', isOn: false, what: 'Lines on the floor every metre from the middle of the field.' },
];

const each = (value: (layer: Layer) => boolean) => Object.fromEntries(layerList.map((layer) => [layer.name, value(layer)])) as unknown as Required<Layers>;

const KEY = 'layers';

/** The choice of an earlier visit; missing layers have their defaults. */
export function storedLayers(text: string | null): Required<Layers> {
  let stored: unknown = null;
  try {
    stored = JSON.parse(text ?? 'null');
  } catch {
    // Malformed: use the defaults.
  }
  const choice = (typeof stored === 'object' && stored !== null ? stored : {}) as Record<string, unknown>;
  return each(({ name, isOn }) => (typeof choice[name] === 'boolean' ? choice[name] : isOn));
}

function storage(): Storage | null {
  try {
    return localStorage;
  } catch {
    return null; // Without storage the choice lasts as long as the page.
  }
}

export const layers = reactive<Required<Layers>>(storedLayers(storage()?.getItem(KEY) ?? null));
export const allHidden = ref(false);
watch(layers, () => {
  try {
    storage()?.setItem(KEY, JSON.stringify(layers));
  } catch {
    // Storage is full or forbidden: the choice lasts as long as the page.
  }
});

const NONE = each(() => false);
export const shownLayers = computed(() => (allHidden.value ? NONE : layers));

export function toggleLayer(name: keyof Layers): void {
  layers[name] = allHidden.value || !layers[name];
  allHidden.value = false;
}
