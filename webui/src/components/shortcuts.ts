// SPDX-License-Identifier: Apache-2.0
// The keys that do something now. What is listed here is both what the keyboard does and what the dialog shows.
import { ref, shallowReactive } from 'vue';

export interface Shortcut {
  /** As KeyboardEvent.key says, letters in lower case. Several mean the same, or the action looks which it is. */
  keys: readonly string[];
  /** What it does, for the dialog. */
  text: string;
  act: (event: KeyboardEvent) => void;
  /** With Ctrl, or Cmd on a Mac. */
  ctrl?: boolean;
  /** Only with Shift, or only without; left out: either. */
  shift?: boolean;
  /** The key has no meaning while this is false, such as to cancel nothing. */
  when?: (event: KeyboardEvent) => boolean;
}

/** Where shortcuts work: the whole page, or one element that has the focus. */
export interface ShortcutGroup {
  title: string;
  shortcuts: readonly Shortcut[];
}

/** The dialog that lists them is shown. */
export const isListOpen = ref(false);

const groups = shallowReactive<ShortcutGroup[]>([]);

export function addGroup(group: ShortcutGroup): () => void {
  groups.push(group);
  return () => { groups.splice(groups.indexOf(group), 1); };
}

/** What the dialog lists: groups of one title together, and each text once. */
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

/** The shortcut that a press means. */
export function meant(shortcuts: readonly Shortcut[], event: Pressed): Shortcut | undefined {
  if (event.altKey) return undefined;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const hasCtrl = event.ctrlKey || event.metaKey;
  return shortcuts.find(({ keys, ctrl = false, shift, when }) => keys.includes(key) && ctrl === hasCtrl
    && (shift === undefined || shift === event.shiftKey) && (when?.(event as KeyboardEvent) ?? true));
}

/** Does what the press means, if anything. */
export function press(shortcuts: readonly Shortcut[], event: KeyboardEvent): boolean {
  // Who types means letters; what a dialog hides is not there.
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

/** The keys as they are printed on a keyboard. */
export const keyNames = ({ keys, ctrl, shift }: Shortcut): string[] =>
  keys.map((key) => [...(ctrl ? ['Ctrl'] : []), ...(shift ? ['Shift'] : []), NAMES[key] ?? (key.length === 1 ? key.toUpperCase() : key)].join(' '));
