// SPDX-License-Identifier: Apache-2.0
import { ref } from 'vue';

/** Panel address of the live page from which the user went back in time; empty: none. */
export const liveHome = ref('');
