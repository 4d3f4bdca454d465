// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted } from 'vue';
import { addGroup, press, type Shortcut } from './shortcuts';

/** Registers shortcuts while a component is mounted; they are inactive while the user types. */
export function useKeys(title: string, shortcuts: readonly Shortcut[]): void {
  const onKey = (event: KeyboardEvent) => { press(shortcuts, event); };
  let remove = () => {};
  onMounted(() => {
    remove = addGroup({ title, shortcuts });
    addEventListener('keydown', onKey);
  });
  onUnmounted(() => {
    remove();
    removeEventListener('keydown', onKey);
  });
}

/** Registers shortcuts of an element that has the focus. Returns its keydown handler. */
export function useFocusKeys(title: string, shortcuts: readonly Shortcut[]): (event: KeyboardEvent) => boolean {
  let remove = () => {};
  onMounted(() => { remove = addGroup({ title, shortcuts }); });
  onUnmounted(() => remove());
  return (event) => press(shortcuts, event);
}
