// SPDX-License-Identifier: Apache-2.0
// The service's raw pixels around a place, and what is derived from them.
import type { Pixels } from '../../api/types';
import type { Triple } from './table';

export interface Place {
  x: number;
  y: number;
}
export interface Rect extends Place {
  width: number;
  height: number;
}

export function bytesOf(base64: string): Uint8Array {
  const text = atob(base64);
  return Uint8Array.from(text, (letter) => letter.charCodeAt(0));
}

/** A square of pixels around a place. */
export const around = ({ x, y }: Place, side: number): Rect => ({ x: x - ((side - 1) >> 1), y: y - ((side - 1) >> 1), width: side, height: side });

/** The rectangle between two corners, clipped to the image; null if nothing remains. */
export function spanned(a: Place, b: Place, picture: { width: number; height: number }): Rect | null {
  const x = Math.max(0, Math.min(a.x, b.x));
  const y = Math.max(0, Math.min(a.y, b.y));
  const right = Math.min(picture.width - 1, Math.max(a.x, b.x));
  const bottom = Math.min(picture.height - 1, Math.max(a.y, b.y));
  return right >= x && bottom >= y ? { x, y, width: right - x + 1, height: bottom - y + 1 } : null;
}

/** Raw pixels and the place for which they were requested. */
export interface Look {
  place: Place;
  pixels: Pixels;
  /** Y, U, V of each cell. */
  yuv: Uint8Array;
  labels: Uint8Array;
  /** Index of the cell that contains the place. */
  index: number;
}

export function lookOf(place: Place, pixels: Pixels): Look | null {
  if (pixels.yuv === null || pixels.labels === null || !pixels.count) return null;
  const column = Math.floor((place.x - pixels.x) / pixels.cell_px);
  const row = Math.floor((place.y - pixels.y) / pixels.cell_px);
  if (column < 0 || row < 0 || column >= pixels.columns || row >= pixels.rows) return null;
  return { place, pixels, yuv: bytesOf(pixels.yuv), labels: bytesOf(pixels.labels), index: row * pixels.columns + column };
}

export const yuvAt = ({ yuv }: Look, index: number): Triple => [yuv[3 * index]!, yuv[3 * index + 1]!, yuv[3 * index + 2]!];

export interface Bars {
  /** Height of each bin, 0 to 1. */
  heights: number[];
  /** Levels spanned by the middle 96 %; null: no pixels. */
  range: [number, number] | null;
  /** First and last bin of that range. */
  bins: [number, number] | null;
}

const LEFT_OUT = 0.02;

/** Converts a histogram with bins of `levels` levels to bars. */
export function barsOf(histogram: readonly number[], levels = 4): Bars {
  const most = Math.max(...histogram);
  const total = histogram.reduce((sum, count) => sum + count, 0);
  if (!total) return { heights: histogram.map(() => 0), range: null, bins: null };
  let low = 0;
  let high = histogram.length - 1;
  for (let seen = histogram[low]!; seen <= total * LEFT_OUT; seen += histogram[low]!) low++;
  for (let seen = histogram[high]!; seen <= total * LEFT_OUT; seen += histogram[high]!) high--;
  return { heights: histogram.map((count) => count / most), range: [low * levels, high * levels + levels - 1], bins: [low, high] };
}
