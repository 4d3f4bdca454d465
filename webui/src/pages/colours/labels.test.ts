// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { choosable, freeValue, keyOf, palette, trialText } from './labels';

const label = (value: number, name: string, color = '#102030') => ({ value, name, color, built_in: value < 10, cells: 0 });
const all = [label(0, 'clear', '#34363a'), label(1, 'field'), label(2, 'orange', '#ff8a1f'), label(9, 'black'), label(11, 'referee'), label(10, 'cup')];

describe('labels', () => {
  it('are ordered by how often they are needed, own ones last', () => {
    expect(choosable(all).map(({ name }) => name)).toEqual(['orange', 'field', 'black', 'cup', 'referee']);
    expect([0, 8, 9, 10].map(keyOf)).toEqual(['1', '9', '0', '']);
  });
  it('are drawn in their colours, hidden ones as clear', () => {
    const shown = palette(all, new Set([2]));
    expect(shown[0]).toBe(0xff3a3634);
    expect(shown[2]).toBe(shown[0]);
    expect(palette(all, new Set())[2]).toBe(0xff1f8aff);
    expect(shown[31]).toBe(shown[0]);
  });
  it('get the first free value', () => {
    expect(freeValue(all)).toBe(12);
    expect(freeValue(Array.from({ length: 32 }, (_, i) => label(i, `l${i}`)))).toBeNull();
  });
  it('say what a click would do', () => {
    expect(trialText({ cells: 27, from: [{ label: 'clear', cells: 24 }, { label: 'orange', cells: 3 }], left_to_carpet: 0 }, 'pink', false)).toBe('adds 27 cells to Pink, 3 of them now Orange');
    expect(trialText({ cells: 1, from: [{ label: 'clear', cells: 1 }], left_to_carpet: 0 }, 'pink', false)).toBe('adds 1 cell to Pink');
    expect(trialText({ cells: 0, from: [], left_to_carpet: 0 }, 'pink', false)).toBe('is already Pink');
    expect(trialText({ cells: 5, from: [{ label: 'clear', cells: 4 }, { label: 'orange', cells: 1 }], left_to_carpet: 12 }, 'pink', false)).toBe('adds 5 cells to Pink, 1 of them now Orange; 12 cells stay carpet');
    expect(trialText({ cells: 0, from: [], left_to_carpet: 3 }, 'pink', false)).toBe('is already Pink; 3 cells stay carpet');
    expect(trialText({ cells: 8, from: [{ label: 'pink', cells: 8 }], left_to_carpet: 0 }, 'pink', true)).toBe('removes 8 cells from Pink');
    expect(trialText({ cells: 0, from: [], left_to_carpet: 0 }, 'pink', true)).toBe('removes nothing from Pink');
  });
});
