// SPDX-License-Identifier: Apache-2.0
// The keyboard shortcuts that are active now: one list for both the key handler and the dialog.
import { ref, shallowReactive } from 'vue';

export interface Shortcut {
  /** KeyboardEvent.key values, letters in lower case. Several are synonyms, or the action distinguishes them. */
  keys: readonly string[];
  /** Description for the dialog. */
  text: string;
  act: (event: KeyboardEvent) => void;
  /** With Ctrl, or Cmd on a Mac. */
  ctrl?: boolean;
  /** Required state of Shift; undefined: either. */
  shift?: boolean;
  /** The key is ignored while this returns false, for example "cancel" without anything to cancel. */
  when?: (event: KeyboardEvent) => boolean;
}

/** Shortcuts of the whole page or of one element that has the focus. */
export interface ShortcutGroup {
  title: string;
  shortcuts: readonly Shortcut[];
}

/** Whether the dialog that lists the shortcuts is open. */
export const isListOpen = ref(false);

const groups = shallowReactive<ShortcutGroup[]>([]);

export function addGroup(group: ShortcutGroup): () => void {
  groups.push(group);
  return () => { groups.splice(groups.indexOf(group), 1); };
}

/** The dialog's list: groups with the same title merged, each text once. */
export function listed(all: readonly ShortcutGroup[] = groups): ShortcutGroup[] {
  const out = new Map<string, Map<string, Shortcut>>();
  for (const { title, shortcuts } of all) {
    const ofTitle = out.get(title) ?? new Map<string, Shortcut>();
    for (const shortcut of shortcuts) ofTitle.set(shortcut.text, shortcut);
    out.set(title, ofTitle);
  }
  return [...out].map(([title, shortcuts]) => ({ title, shortcuts: [...shortcuts.values()] }));
}

const isTextField = (target: EventTarget | null) => target instanceof HTMLElement
  && (target.isContentEditable || target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement
    || (target instanceof HTMLInputElement && !['range', 'checkbox', 'radio', 'button', 'file'].includes(target.type)));

type Pressed = Pick<KeyboardEvent, 'key' | 'ctrlKey' | 'metaKey' | 'altKey' | 'shiftKey'>;

/** The shortcut for a key press. */
export function meant(shortcuts: readonly Shortcut[], event: Pressed): Shortcut | undefined {
  if (event.altKey) return undefined;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const hasCtrl = event.ctrlKey || event.metaKey;
  return shortcuts.find(({ keys, ctrl = false, shift, when }) => keys.includes(key) && ctrl === hasCtrl
    && (shift === undefined || shift === event.shiftKey) && (when?.(event as KeyboardEvent) ?? true));
}

/** Runs the shortcut for a key press; returns whether there is one. */
export function press(shortcuts: readonly Shortcut[], event: KeyboardEvent): boolean {
  // Keys are ignored while the user types or a dialog is open.
  if (event.defaultPrevented || isTextField(event.target) || document.querySelector('dialog[open]')) return false;
  const shortcut = meant(shortcuts, event);
  if (!shortcut) return false;
  event.preventDefault();
  shortcut.act(event);
  return true;
}

const NAMES: Record<string, string> = {
  ' ': 'Space', ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', Escape: 'Esc', Delete: 'Del', Backspace: '⌫',
};

/** Key labels as printed on a keyboard. */
export const keyNames = ({ keys, ctrl, shift }: Shortcut): string[] =>
  keys.map((key) => [...(ctrl ? ['Ctrl'] : []), ...(shift ? ['Shift'] : []), NAMES[key] ?? (key.length === 1 ? key.toUpperCase() : key)].join(' '));
