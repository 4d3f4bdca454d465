// SPDX-License-Identifier: Apache-2.0
// What the live field can show.
import { ref } from 'vue';

export const LAYERS = [
  { value: 'tracked', text: 'Tracked', title: 'What the service makes of all cameras' },
  { value: 'raw', text: 'Raw', title: 'What single cameras report' },
  { value: 'agreement', text: 'Agreement', title: 'How far cameras are apart, by places' },
  { value: 'coverage', text: 'Coverage', title: 'How many cameras see each place' },
] as const;
export type Layer = (typeof LAYERS)[number]['value'];

/** Kept while other pages are shown. */
export const layer = ref<Layer>('tracked');
