// SPDX-License-Identifier: Apache-2.0
// The layers of the live field.
import { ref } from 'vue';

export const LAYERS = [
  { value: 'tracked', text: 'Tracked', title: 'Tracks from all cameras' },
  { value: 'raw', text: 'Raw', title: 'Detections of single cameras' },
  { value: 'agreement', text: 'Agreement', title: 'Disagreement between cameras, by place' },
  { value: 'coverage', text: 'Coverage', title: 'How many cameras see each place' },
] as const;
export type Layer = (typeof LAYERS)[number]['value'];

/** Kept while other pages are shown. */
export const layer = ref<Layer>('tracked');
