// SPDX-License-Identifier: Apache-2.0
// A colour table: one label for each cell of the colour cube, ordered U, V, Y with Y innermost.
import { decodeRuns } from './runs';

/** Y, U, V. */
export type Triple = [number, number, number];

export interface Table {
  /** Bits per channel: 5 to 8. */
  bits: number;
  labels: Uint8Array;
}

export const CLEAR = 0;
const LEVELS = 256;

/** Cells along an edge of the cube. */
export const sideOf = (table: Table) => 1 << table.bits;
/** Levels that a cell spans along an edge. */
export const stepOf = (table: Table) => LEVELS >> table.bits;

/** Index of a cell, from its coordinates. */
export const cellIndex = ({ bits }: Table, y: number, u: number, v: number) => (((u << bits) | v) << bits) | y;
export const cellOf = (table: Table, level: number) => level >> (8 - table.bits);
/** The level at the centre of a cell. */
export const levelOf = (table: Table, cell: number) => cell * stepOf(table) + (stepOf(table) >> 1);
export const labelAt = (table: Table, [y, u, v]: Triple) =>
  table.labels[cellIndex(table, cellOf(table, y), cellOf(table, u), cellOf(table, v))]!;

const MAGIC = 'SSLVLUT2', MAGIC_WITH_PRINTS = 'SSLVLUT3';
/** A label and four 16-bit numbers. */
const PRINT_BYTES = 9;

/** Decodes a .lut file of version 2 or 3 (daemon/vision/lut_codec.h). Throws a description of the error. */
export function decodeTable(buffer: ArrayBuffer): Table {
  const bytes = new Uint8Array(buffer);
  const magic = new TextDecoder('latin1').decode(bytes.subarray(0, MAGIC.length));
  if (magic !== MAGIC && magic !== MAGIC_WITH_PRINTS) throw new Error('this is not a .lut file of version 2 or 3');
  const bits = bytes[8] ?? 0;
  if (bits < 5 || bits > 8) throw new Error(`a table of ${bits} bits`);
  let at = 10;
  // Values are the service's own here, so the names are skipped.
  for (let left = bytes[9] ?? 0; left > 0; left--) at += 2 + (bytes[at + 1] ?? 0);
  // Skips the descriptions of prints, which only the service's detectors use.
  if (magic === MAGIC_WITH_PRINTS) at += 1 + PRINT_BYTES * (bytes[at] ?? 0);
  return { bits, labels: decodeRuns(bytes, at, 1 << (3 * bits)) };
}

/** The labels at one Y as drawn: rows from the highest V down, U from left to right. */
export function sliceOf(table: Table, y: number): Uint8Array {
  const side = sideOf(table);
  const slice = new Uint8Array(side * side);
  for (let u = 0; u < side; u++) {
    for (let v = 0; v < side; v++) slice[(side - 1 - v) * side + u] = table.labels[cellIndex(table, y, u, v)]!;
  }
  return slice;
}

/** Number of cells at each Y: of all labels that count, and of `label`. */
export function occupancy(table: Table, label: number, counts: (label: number) => boolean): { all: number[]; one: number[] } {
  const side = sideOf(table);
  const all = new Array<number>(side).fill(0);
  const one = new Array<number>(side).fill(0);
  const counted = Array.from({ length: LEVELS }, (_, value) => counts(value));
  const { labels } = table;
  const mask = side - 1;
  for (let i = 0; i < labels.length; i++) {
    const value = labels[i]!;
    if (value === CLEAR) continue;
    if (counted[value]) all[i & mask]!++;
    if (value === label) one[i & mask]!++;
  }
  return { all, one };
}

/** Whether a label is the colour of an object, which is distinguished by its hue. 1, 8 and 9 are field, white, black. */
export const isColour = (label: number) => label !== CLEAR && label !== 1 && label !== 8 && label !== 9;

/** Marks cells that share a face with a cell of another colour: 1 for each, ordered as the table. */
export function conflictCells(table: Table): { mask: Uint8Array; count: number } {
  const { bits, labels } = table;
  const side = sideOf(table);
  const mask = new Uint8Array(labels.length);
  const colour = Array.from({ length: LEVELS }, (_, value) => isColour(value));
  const strides = [1, side, side * side];
  let count = 0;
  const mark = (i: number) => { if (!mask[i]) { mask[i] = 1; count++; } };
  for (let i = 0; i < labels.length; i++) {
    const label = labels[i]!;
    if (!colour[label]) continue;
    for (let axis = 0; axis < 3; axis++) {
      if (((i >> (axis * bits)) & (side - 1)) === side - 1) continue;
      const other = labels[i + strides[axis]!]!;
      if (other !== label && colour[other]) { mark(i); mark(i + strides[axis]!); }
    }
  }
  return { mask, count };
}

export interface Cube {
  /** Cells along an edge. */
  side: number;
  /** Coordinates y, u, v of each cube, one after the other. */
  at: Uint8Array;
  labels: Uint8Array;
  count: number;
}

/** The cells of a coarser table that are visible from outside; labels that are not shown hide nothing. */
export function surface(table: Table, bits: number, isShown: (label: number) => boolean): Cube {
  const shown = Array.from({ length: LEVELS }, (_, value) => value !== CLEAR && isShown(value));
  const side = 1 << bits;
  const fine = table.bits - bits;
  const coarse = new Uint8Array(side ** 3);
  const index = (y: number, u: number, v: number) => (u * side + v) * side + y;
  const half = fine > 0 ? 1 << (fine - 1) : 0;
  for (let u = 0; u < side; u++) {
    for (let v = 0; v < side; v++) {
      for (let y = 0; y < side; y++) {
        const label = table.labels[cellIndex(table, (y << fine) + half, (u << fine) + half, (v << fine) + half)]!;
        if (shown[label]) coarse[index(y, u, v)] = label;
      }
    }
  }
  const at: number[] = [];
  const labels: number[] = [];
  const last = side - 1;
  for (let u = 0; u < side; u++) {
    for (let v = 0; v < side; v++) {
      for (let y = 0; y < side; y++) {
        const label = coarse[index(y, u, v)]!;
        if (!label) continue;
        const covered = y > 0 && y < last && u > 0 && u < last && v > 0 && v < last
          && coarse[index(y - 1, u, v)] && coarse[index(y + 1, u, v)] && coarse[index(y, u - 1, v)]
          && coarse[index(y, u + 1, v)] && coarse[index(y, u, v - 1)] && coarse[index(y, u, v + 1)];
        if (covered) continue;
        at.push(y, u, v);
        labels.push(label);
      }
    }
  }
  return { side, at: Uint8Array.from(at), labels: Uint8Array.from(labels), count: labels.length };
}
