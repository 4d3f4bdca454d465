// SPDX-License-Identifier: Apache-2.0
// A series over the last minute as an SVG path.
import { HISTORY_MS, type Sample } from '../state/history';

/** A hole longer than this is left open: nothing was measured there. */
const HOLE_MS = 3000;

export interface Plane {
  width: number;
  height: number;
  /** The value at the upper edge; the lower one is zero. */
  top: number;
}

const round = (value: number) => Math.round(value * 10) / 10;

export function seriesPaths(samples: readonly Sample[], value: (sample: Sample) => number, now: number, plane: Plane) {
  let line = '';
  let area = '';
  let lastX: number | null = null;
  let lastAt = -Infinity;
  const close = () => {
    if (lastX !== null) area += `V${plane.height}Z`;
  };
  for (const sample of samples) {
    const x = round((1 - (now - sample.at) / HISTORY_MS) * plane.width);
    if (x < 0) continue;
    const y = round(plane.height * (1 - Math.min(1, value(sample) / plane.top)));
    if (lastX === null || sample.at - lastAt > HOLE_MS) {
      close();
      line += `M${x} ${y}`;
      area += `M${x} ${plane.height}V${y}`;
    } else {
      line += `L${x} ${y}`;
      area += `L${x} ${y}`;
    }
    lastX = x;
    lastAt = sample.at;
  }
  close();
  return { line, area };
}

/** The next of 1, 2, 3, 4, 6, 8, 10, 15, 20 … times a power of ten, for an axis' end. */
export function niceTop(value: number): number {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const step = [1, 1.5, 2, 3, 4, 6, 8, 10].find((s) => s * power >= value) ?? 10;
  return step * power;
}
