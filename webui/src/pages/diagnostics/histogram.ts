// SPDX-License-Identifier: Apache-2.0
// Histograms of durations on one logarithmic axis, as paths in a plane of 100 by 1.
import type { Histogram } from '../../api/types';

export interface LogAxis {
  /** Microseconds at the left and the right edge. */
  from: number;
  to: number;
}

/** The axis that covers all of them; null if nothing was measured. */
export function commonAxis(histograms: readonly Histogram[]): LogAxis | null {
  const filled = histograms.filter(({ edges_us }) => edges_us.length > 1);
  if (!filled.length) return null;
  return { from: Math.min(...filled.map(({ edges_us }) => edges_us[0]!)), to: Math.max(...filled.map(({ edges_us }) => edges_us.at(-1)!)) };
}

/** Position on the axis in percent of its length. */
export function placeOf({ from, to }: LogAxis, us: number): number {
  return (Math.log(us / from) / Math.log(to / from)) * 100;
}

const TICKS_PER_DECADE = [1, 2, 5];
const MOST_TICKS = 6;

/** Round durations on the axis: 1, 2, 5 of each decade, or only decades if those are too many. */
export function ticksOf(axis: LogAxis): number[] {
  const decades = Array.from({ length: 12 }, (_, i) => 10 ** (i - 2));
  const within = (steps: number[]) => decades.flatMap((decade) => steps.map((step) => Number((decade * step).toPrecision(1)))).filter((us) => us >= axis.from && us <= axis.to);
  const fine = within(TICKS_PER_DECADE);
  return fine.length > MOST_TICKS ? within([1]) : fine;
}

const round = (value: number) => Math.round(value * 1000) / 1000;

/** Outline of the bars, the highest of them 1 high; y = 0 is at the top. */
export function shapeOf({ edges_us, counts }: Histogram, axis: LogAxis): string {
  const most = Math.max(...counts);
  if (!counts.length || most <= 0) return '';
  let path = `M${round(placeOf(axis, edges_us[0]!))} 1`;
  counts.forEach((count, i) => {
    path += `V${round(1 - count / most)}H${round(placeOf(axis, edges_us[i + 1]!))}`;
  });
  return `${path}V1Z`;
}
