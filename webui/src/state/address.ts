// SPDX-License-Identifier: Apache-2.0
// Whether the panel's address is shown.
import { ref } from 'vue';

export const showsAddress = ref(false);
export const openAddress = () => { showsAddress.value = true; };
