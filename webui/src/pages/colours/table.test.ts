// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { cellIndex, conflictCells, decodeTable, labelAt, occupancy, sliceOf, surface, type Table } from './table';

const BITS = 5;
const SIDE = 32;
const empty = (bits = BITS): Table => ({ bits, labels: new Uint8Array(1 << (3 * bits)) });
const set = (table: Table, label: number, ...cells: [number, number, number][]) => {
  for (const [y, u, v] of cells) table.labels[cellIndex(table, y, u, v)] = label;
  return table;
};

/** A .lut file as specified in daemon/vision/lut_codec.h. */
function lut(bits: number, names: [number, string][], runs: number[], prints: number[][] | null = null): ArrayBuffer {
  const text = new TextEncoder();
  const entries = names.flatMap(([value, name]) => [value, text.encode(name).length, ...text.encode(name)]);
  const before = prints ? [prints.length, ...prints.flat()] : [];
  return Uint8Array.from([...text.encode(prints ? 'SSLVLUT3' : 'SSLVLUT2'), bits, names.length, ...entries, ...before, ...runs]).buffer;
}

describe('a .lut file', () => {
  it('is read run by run, Y innermost, then V, then U', () => {
    // 33 clear: the first run of Y and one cell of the next V. Then 3 pink, the rest clear: 32732 = 0x7fdc.
    const table = decodeTable(lut(5, [[0, 'clear'], [5, 'pink']], [0, 33, 5, 3, 0, 0xdc, 0xff, 0x01]));
    expect(table.bits).toBe(5);
    expect(table.labels).toHaveLength(32768);
    expect([0, 1, 2, 3, 4].map((y) => table.labels[cellIndex(table, y, 0, 1)])).toEqual([0, 5, 5, 5, 0]);
    expect(labelAt(table, [2 * 8 + 7, 0, 8])).toBe(5);
    expect(labelAt(table, [2 * 8 + 7, 8, 8])).toBe(0);
  });
  it('may tell what prints look like, which the page passes over', () => {
    const prints = [[5, 0xb8, 0x0b, 0xd0, 0x07, 0x88, 0x13, 0, 0], [7, 1, 2, 3, 4, 5, 6, 7, 8]];
    const table = decodeTable(lut(5, [[0, 'clear'], [5, 'pink'], [7, 'green']], [5, 1, 0, 0xff, 0xff, 0x01], prints));
    expect([...table.labels.subarray(0, 3)]).toEqual([5, 0, 0]);
  });
  it('is refused when it is damaged', () => {
    expect(() => decodeTable(new TextEncoder().encode('SSLVLUT1').buffer)).toThrow('not a .lut file');
    expect(() => decodeTable(lut(9, [], []))).toThrow('9 bits');
    expect(() => decodeTable(lut(5, [], [0, 10]))).toThrow('10 labels instead of 32768');
    expect(() => decodeTable(lut(5, [], [0, 0xff]))).toThrow('cut short');
    expect(() => decodeTable(lut(5, [], [0, 0x81, 0x80, 0x02]))).toThrow('more than 32768');
    expect(() => decodeTable(lut(5, [], [0, 0xff, 0xff, 0xff, 0xff, 0xff, 1]))).toThrow('too long');
  });
});

describe('looking at a table', () => {
  it('shows a slice with the highest V on top', () => {
    const slice = sliceOf(set(empty(), 4, [7, 2, 31], [7, 31, 0], [8, 0, 0]), 7);
    expect(slice[2]).toBe(4);
    expect(slice[31 * SIDE + 31]).toBe(4);
    expect(slice.reduce((sum, label) => sum + label, 0)).toBe(8);
  });
  it('counts how much lies at each Y', () => {
    const { all, one } = occupancy(set(empty(), 3, [5, 1, 1], [5, 2, 2], [6, 0, 0]), 3, () => true);
    expect([all[4], all[5], all[6]]).toEqual([0, 2, 1]);
    expect(one).toEqual(all);
    expect(occupancy(set(empty(), 3, [5, 1, 1]), 4, (label) => label !== 3)).toMatchObject({ all: new Array(SIDE).fill(0), one: new Array(SIDE).fill(0) });
  });
});

describe('where colours meet', () => {
  it('counts the cells of both that touch by a face', () => {
    expect(conflictCells(set(empty(), 2, [1, 1, 1], [5, 5, 5])).count).toBe(0);
    const table = set(set(empty(), 2, [1, 1, 1], [1, 1, 2]), 3, [2, 1, 1], [3, 1, 1], [9, 1, 2]);
    const { mask, count } = conflictCells(table);
    expect(count).toBe(2);
    expect(mask[cellIndex(table, 1, 1, 1)]).toBe(1);
    expect(mask[cellIndex(table, 2, 1, 1)]).toBe(1);
    expect(mask[cellIndex(table, 3, 1, 1)]).toBe(0);
  });
  it('does not count corners, the other end of the cube, or what is no colour', () => {
    expect(conflictCells(set(set(empty(), 2, [1, 1, 1]), 3, [2, 2, 1])).count).toBe(0);
    expect(conflictCells(set(set(empty(), 2, [31, 1, 1]), 3, [0, 1, 2])).count).toBe(0);
    for (const label of [0, 1, 8, 9]) expect(conflictCells(set(set(empty(), 2, [1, 1, 1]), label, [2, 1, 1])).count).toBe(0);
    expect(conflictCells(set(set(empty(), 2, [1, 1, 1]), 12, [1, 2, 1])).count).toBe(2);
  });
});

describe('the surface', () => {
  it('leaves out what is covered on all sides', () => {
    const cells: [number, number, number][] = [];
    for (let y = 3; y < 6; y++) for (let u = 3; u < 6; u++) for (let v = 3; v < 6; v++) cells.push([y, u, v]);
    const cube = surface(set(empty(), 4, ...cells), 5, () => true);
    expect(cube.count).toBe(26);
    expect([...cube.at].length).toBe(78);
    expect(surface(set(empty(), 4, ...cells), 5, (label) => label !== 4).count).toBe(0);
  });
  it('is shown coarser than the table is', () => {
    const table = empty(7);
    table.labels.fill(5);
    const cube = surface(table, 5, () => true);
    expect(cube.side).toBe(32);
    expect(cube.count).toBe(32 ** 3 - 30 ** 3);
  });
});
