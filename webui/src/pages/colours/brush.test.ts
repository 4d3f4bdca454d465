// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { between, paint, strokeCommands, type Brush } from './brush';
import { cellIndex, sideOf, type Table } from './table';

const table = (bits = 7): Table => ({ bits, labels: new Uint8Array(1 << (3 * bits)) });
const ball: Brush = { shape: 'ball', size: 3, depth: 1, onlyClear: false };
const at = { y: 60, u: 20, v: 30 };

describe('the brush', () => {
  it('takes as many cells as it says', () => {
    const one = table();
    expect(paint(one, { ...ball, size: 1 }, at, 5)).toBe(1);
    expect(one.labels[cellIndex(one, 60, 20, 30)]).toBe(5);
    expect(paint(table(), ball, at, 5)).toBe(9);
    expect(paint(table(), { ...ball, shape: 'box', size: 5, depth: 3 }, at, 5)).toBe(75);
    // 5 x 5 x 5 cells without those farther than 2.5 cells away.
    expect(paint(table(), { ...ball, size: 5, depth: 5 }, at, 5)).toBe(81);
  });
  it('is as the service draws it where cells are single levels', () => {
    expect(paint(table(8), ball, at, 5)).toBe(5);
    expect(strokeCommands(table(8), ball, [at], 'pink')[0]).toMatchObject({ radius: [0, 1, 1], at: [60, 20, 30] });
  });
  it('says only what changed, and leaves others alone if wanted', () => {
    const mine = table();
    paint(mine, { ...ball, size: 1 }, at, 4);
    expect(paint(mine, { ...ball, onlyClear: true }, at, 5)).toBe(8);
    expect(mine.labels[cellIndex(mine, 60, 20, 30)]).toBe(4);
    expect(paint(mine, ball, at, 5)).toBe(1);
    expect(paint(mine, { ...ball, onlyClear: true }, at, 0)).toBe(9);
    expect(mine.labels.every((label) => label === 0)).toBe(true);
  });
  it('ends at the edges of the cube', () => {
    const mine = table(5);
    expect(paint(mine, { ...ball, shape: 'box', depth: 3 }, { y: 0, u: 0, v: sideOf(mine) - 1 }, 5)).toBe(8);
  });
  it('tells the service places and radii in levels', () => {
    expect(strokeCommands(table(), ball, [at], 'pink')).toEqual([{ op: 'paint', label: 'pink', shape: 'ball', over: 'any', at: [121, 41, 61], radius: [1, 3, 3] }]);
    expect(strokeCommands(table(5), { ...ball, shape: 'box', onlyClear: true }, [{ y: 1, u: 2, v: 3 }], 'pink')).toEqual([{ op: 'paint', label: 'pink', shape: 'box', over: 'clear', at: [12, 20, 28], radius: [4, 12, 12] }]);
    expect(strokeCommands(table(), ball, [at], null)).toEqual([{ op: 'erase', shape: 'ball', at: [121, 41, 61], radius: [1, 3, 3] }]);
  });
  it('leaves no gap in a fast stroke', () => {
    const way = between({ y: 1, u: 0, v: 0 }, { y: 1, u: 5, v: -2 });
    expect(way).toHaveLength(5);
    expect(way.at(-1)).toEqual({ y: 1, u: 5, v: -2 });
    let [u, v] = [0, 0];
    for (const cell of way) {
      expect(Math.max(Math.abs(cell.u - u), Math.abs(cell.v - v))).toBe(1);
      [u, v] = [cell.u, cell.v];
    }
    expect(between(at, at)).toEqual([]);
  });
});
