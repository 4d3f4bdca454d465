// SPDX-License-Identifier: Apache-2.0
// The brush of the slice: the cells it covers, and its commands for the service.
import type { ColorCommand } from '../../api/types';
import { cellIndex, CLEAR, levelOf, sideOf, stepOf, type Table, type Triple } from './table';

export interface Brush {
  shape: 'ball' | 'box';
  /** Width in U and V, cells. */
  size: number;
  /** Extent in Y, cells. */
  depth: number;
  /** Paints only clear cells. */
  onlyClear: boolean;
}

/** A place in cell coordinates. */
export interface Cell {
  y: number;
  u: number;
  v: number;
}

/** Half of the brush's extent in levels, rounded down: the centre of the outermost cell is just inside. */
export const radiusOf = (table: Table, brush: Brush): Triple => {
  const half = (cells: number) => Math.floor((cells * stepOf(table)) / 2);
  return [half(brush.depth), half(brush.size), half(brush.size)];
};

/** The service's commands for a stroke over these cells. `label` null: erases. */
export function strokeCommands(table: Table, brush: Brush, cells: Cell[], label: string | null): ColorCommand[] {
  const radius = radiusOf(table, brush);
  return cells.map(({ y, u, v }) => {
    const at: Triple = [levelOf(table, y), levelOf(table, u), levelOf(table, v)];
    const where = { shape: brush.shape, at, radius };
    return label === null ? { op: 'erase', ...where } : { op: 'paint', label, over: brush.onlyClear ? 'clear' : 'any', ...where };
  });
}

/**
 * Paints a local copy of the table as the service will (daemon/colors/table_edit.cpp). Returns the number of changed
 * cells.
 */
export function paint(table: Table, brush: Brush, at: Cell, label: number): number {
  const [ry, ru, rv] = radiusOf(table, brush);
  const last = sideOf(table) - 1;
  const step = stepOf(table);
  const span = (middle: number, radius: number) => [Math.max(0, middle - Math.floor(radius / step)), Math.min(last, middle + Math.floor(radius / step))] as const;
  const share = (cells: number, radius: number) => (cells === 0 ? 0 : ((cells * step) / radius) ** 2);
  const [ys, us, vs] = [span(at.y, ry), span(at.u, ru), span(at.v, rv)];
  let changed = 0;
  for (let u = us[0]; u <= us[1]; u++) {
    for (let v = vs[0]; v <= vs[1]; v++) {
      for (let y = ys[0]; y <= ys[1]; y++) {
        if (brush.shape === 'ball' && share(y - at.y, ry) + share(u - at.u, ru) + share(v - at.v, rv) > 1 + 1e-9) continue;
        const index = cellIndex(table, y, u, v);
        const was = table.labels[index]!;
        if (was === label || (brush.onlyClear && label !== CLEAR && was !== CLEAR)) continue;
        table.labels[index] = label;
        changed++;
      }
    }
  }
  return changed;
}

/** The cells along a straight stroke, without the first one and without gaps that a brush could show. */
export function between(from: Cell, to: Cell): Cell[] {
  const steps = Math.max(Math.abs(to.u - from.u), Math.abs(to.v - from.v));
  return Array.from({ length: steps }, (_, i) => {
    const share = (i + 1) / steps;
    return { y: to.y, u: Math.round(from.u + (to.u - from.u) * share), v: Math.round(from.v + (to.v - from.v) * share) };
  });
}
