// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { keyNames, listed, meant, type Shortcut } from './shortcuts';

const pressed = (key: string, held: Partial<KeyboardEvent> = {}) => ({ key, ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, ...held });
const shortcut = (text: string, keys: string[], more: Partial<Shortcut> = {}): Shortcut => ({ text, keys, act: () => {}, ...more });
const freeze = shortcut('Freeze', ['f']);
const undo = shortcut('Undo', ['z'], { ctrl: true, shift: false });
const redo = shortcut('Redo', ['z'], { ctrl: true, shift: true });
const help = shortcut('Help', ['?']);
const all = [freeze, undo, redo, help];

describe('a press', () => {
  it('means the shortcut of its key and modifiers', () => {
    expect(meant(all, pressed('f'))).toBe(freeze);
    expect(meant(all, pressed('F', { shiftKey: true }))).toBe(freeze);
    expect(meant(all, pressed('z', { ctrlKey: true }))).toBe(undo);
    expect(meant(all, pressed('z', { metaKey: true }))).toBe(undo);
    expect(meant(all, pressed('Z', { ctrlKey: true, shiftKey: true }))).toBe(redo);
    expect(meant(all, pressed('?', { shiftKey: true }))).toBe(help);
  });
  it('of the browser means nothing here', () => {
    expect(meant(all, pressed('f', { ctrlKey: true }))).toBeUndefined();
    expect(meant(all, pressed('f', { altKey: true }))).toBeUndefined();
    expect(meant(all, pressed('z'))).toBeUndefined();
  });
  it('means nothing while its shortcut has no meaning', () => {
    expect(meant([shortcut('Cancel', ['Escape'], { when: () => false })], pressed('Escape'))).toBeUndefined();
  });
});

it('the list has groups of one title together and each text once', () => {
  expect(listed([{ title: 'A', shortcuts: [freeze] }, { title: 'B', shortcuts: [undo] }, { title: 'A', shortcuts: [freeze, help] }]))
    .toEqual([{ title: 'A', shortcuts: [freeze, help] }, { title: 'B', shortcuts: [undo] }]);
});

it('keys have the names that are printed on them', () => {
  expect(keyNames(redo)).toEqual(['Ctrl Shift Z']);
  expect(keyNames(shortcut('', [' ', 'ArrowLeft', '[']))).toEqual(['Space', '←', '[']);
});
