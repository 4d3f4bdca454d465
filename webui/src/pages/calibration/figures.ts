// SPDX-License-Identifier: Apache-2.0
// A calibration's figures, prepared for drawing.
import type { CalibrationReport } from '../../api/types';

export type MapPoint = CalibrationReport['error_map'][number];
export type Level = 'on_floor_mm' | 'at_150_mm';

export interface Cell {
  x: number;
  y: number;
  width: number;
  height: number;
  mm: number;
  /** 0 is the smallest error, BINS - 1 the largest. */
  bin: number;
}

export const BINS = 6;

/** The smallest difference between distinct values; Infinity if there is none. */
function stepOf(values: number[]): number {
  const sorted = [...new Set(values)].sort((a, b) => a - b);
  return sorted.slice(1).reduce((least, value, i) => Math.min(least, value - sorted[i]!), Infinity);
}

/** The smallest 1, 2 or 5 times a power of ten that is not below `value`. */
export function niceTop(value: number): number {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  const factor = [1, 2, 5, 10].find((one) => one * power >= value * (1 - 1e-9))!;
  return Number((factor * power).toPrecision(3));
}

/** The map's points as adjacent cells, and the top of its scale. */
export function errorCells(map: MapPoint[], level: Level): { cells: Cell[]; top: number } {
  const points = map.filter((point) => point[level] !== null);
  const stepX = stepOf(map.map(({ x_mm }) => x_mm));
  const stepY = stepOf(map.map(({ y_mm }) => y_mm));
  const width = Number.isFinite(stepX) ? stepX : stepY;
  const height = Number.isFinite(stepY) ? stepY : stepX;
  const top = niceTop(Math.max(0, ...points.map((point) => point[level]!)));
  const cells = points.map((point) => ({
    x: point.x_mm - width / 2, y: point.y_mm - height / 2, width, height, mm: point[level]!,
    bin: Math.min(BINS - 1, Math.floor((point[level]! / top) * BINS)),
  }));
  return { cells: Number.isFinite(width) ? cells : [], top };
}

/** Share of the visible field with an error below `mm`, 0 to 1. */
export const shareBelow = (cells: Cell[], mm: number): number => (cells.length ? cells.filter((cell) => cell.mm < mm).length / cells.length : 0);

export interface LineRow {
  name: string;
  rms_px: number | null;
  rms_mm: number | null;
  worst_px: number | null;
  found: string;
  /** Length relative to the longest bar, 0 to 1. */
  share: number;
  doubt: string;
}

/** A line is doubtful if its error is this many times the median and above DOUBT_PX. */
const DOUBT_FACTOR = 2.5;
const DOUBT_PX = 0.1;

export function lineRows(lines: CalibrationReport['lines'], title: (name: string) => string): LineRow[] {
  const known = lines.map(({ rms_px }) => rms_px).filter((px): px is number => px !== null).sort((a, b) => a - b);
  const middle = known[Math.floor((known.length - 1) / 2)] ?? 0;
  const longest = known.at(-1) ?? 0;
  return lines.map((line) => {
    const off = line.rms_px !== null && line.rms_px > DOUBT_PX && line.rms_px > DOUBT_FACTOR * middle;
    const missing = line.expected > 0 && line.patches < line.expected / 2;
    return {
      name: title(line.name), rms_px: line.rms_px, rms_mm: line.rms_mm, worst_px: line.worst_px, found: `${line.patches} of ${line.expected}`,
      share: longest > 0 && line.rms_px !== null ? line.rms_px / longest : 0,
      doubt: off ? 'painted elsewhere?' : missing ? `only ${line.patches} of ${line.expected} pieces found` : '',
    };
  });
}

/** Small figures get more decimals: 0.015, 0.13, 1.6, 134 */
export function figures(value: number | null | undefined): string | null {
  if (value === null || value === undefined || !Number.isFinite(value)) return null;
  const size = Math.abs(value);
  const digits = size >= 99.5 ? 0 : size >= 9.95 ? 1 : size >= 0.0995 ? 2 : 3;
  return value.toFixed(digits).replace('-', '−');
}
