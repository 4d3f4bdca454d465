// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { itemAt, itemsOf, moved, namesOf, withAdded } from './stack';

const usual = ['segment', 'robots', 'balls', 'publish'];

describe('stack', () => {
  it('shows what of the usual stack is switched off', () => {
    const items = itemsOf(['segment', 'balls', 'publish'], usual);
    expect(items.map(({ name, isOn }) => `${name} ${isOn ? 'on' : 'off'}`)).toEqual(['segment on', 'robots off', 'balls on', 'publish on']);
    expect(namesOf(items)).toEqual(['segment', 'balls', 'publish']);
    expect(itemsOf([], ['a', 'b']).map(({ name }) => name)).toEqual(['a', 'b']);
  });
  it('is rearranged', () => {
    expect(moved(['a', 'b', 'c'], 0, 2)).toEqual(['b', 'c', 'a']);
    expect(moved(['a', 'b', 'c'], 0, -1)).toEqual(['a', 'b', 'c']);
    expect(namesOf(withAdded(itemsOf(usual, usual), 'new'))).toEqual(['segment', 'robots', 'balls', 'new', 'publish']);
    expect(withAdded([], 'new')).toEqual([{ name: 'new', isOn: true }]);
  });
  it('finds the stage a refusal is about', () => {
    const items = itemsOf(['segment', 'balls', 'publish'], usual);
    expect(itemAt(items, "/cameras/0/stack/1: stage 'balls' needs 'robots'")).toBe(2);
    expect(itemAt(items, 'another error')).toBeNull();
    expect(itemAt(items, '/cameras/0/stack/9: x')).toBeNull();
  });
});
