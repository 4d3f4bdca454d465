// SPDX-License-Identifier: Apache-2.0
// The last minute of a series as an SVG path.
import { HISTORY_MS } from '../state/history';

/** Longer gaps are left open: nothing was measured there. */
const HOLE_MS = 3000;

export interface Plane {
  width: number;
  height: number;
  /** Value at the upper edge; the lower edge is zero. */
  top: number;
}

const round = (value: number) => Math.round(value * 10) / 10;

export function seriesPaths<Sample extends { at: number }>(samples: readonly Sample[], value: (sample: Sample) => number, now: number, plane: Plane) {
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

export interface Axis {
  top: number;
  ticks: number[];
}

const MOST_STEPS = 4;

/** An axis from zero to at least `value`, with few ticks at round numbers. */
export function axisFor(value: number): Axis {
  const least = Math.max(value, 1e-6) / MOST_STEPS;
  const power = 10 ** Math.floor(Math.log10(least));
  const digits = Math.max(0, 1 - Math.floor(Math.log10(least)));
  const step = ([1, 2, 2.5, 5].find((s) => s * power >= least) ?? 10) * power;
  const steps = Math.ceil(value / step - 1e-9) || 1;
  const ticks = Array.from({ length: steps + 1 }, (_, i) => Number((i * step).toFixed(digits)));
  return { top: steps * step, ticks };
}
