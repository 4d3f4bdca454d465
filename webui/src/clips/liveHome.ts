// SPDX-License-Identifier: Apache-2.0
import { ref } from 'vue';

/** The live page from which somebody went back in time, as an address of the panel; empty: they came another way. */
export const liveHome = ref('');
