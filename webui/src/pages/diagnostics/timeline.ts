// SPDX-License-Identifier: Apache-2.0
// Follows the service's timeline: the first answer is complete, later ones add their seconds.
import type { CameraTimeline, Timeline } from '../../api/types';

export const LONGEST_S = 600;
/** These seconds are requested again, so that nothing is missed between two answers. */
const OVERLAP_S = 5;
/** No answer is this late: the clock was set back. */
const CLOCK_WAS_SET_S = 60;

export const figures = ['fps', 'latency_p50_ms', 'latency_p99_ms', 'robots', 'balls', 'dropped', 'incomplete'] as const satisfies readonly (keyof CameraTimeline)[];
export type Figure = (typeof figures)[number];
export type CameraSeries = Record<Figure, (number | null)[]>;

export interface Series {
  /** Unix seconds, ascending. A gap in time is a sample without values. */
  times: number[];
  /** By camera id; all lists are as long as `times`. */
  cameras: Map<number, CameraSeries>;
}

export const noSeries: Series = { times: [], cameras: new Map() };

const emptyCamera = (length: number) =>
  Object.fromEntries(figures.map((figure) => [figure, new Array<number | null>(length).fill(null)])) as CameraSeries;

/** Adds the answer's newer seconds and keeps ten minutes; starts over if the service's clock was set back. */
export function follow(series: Series, { interval_s, time_s, cameras }: Timeline): Series {
  const last = series.times.at(-1) ?? -Infinity;
  if (time_s.length && time_s.at(-1)! < last - CLOCK_WAS_SET_S) return follow(noSeries, { interval_s, time_s, cameras });
  const times = [...series.times];
  /** Indices of the new samples in the answer; null is a gap. */
  const added: (number | null)[] = [];
  time_s.forEach((time, i) => {
    if (time <= last) return;
    const before = times.at(-1);
    if (before !== undefined && time - before > 1.9 * interval_s) {
      times.push(before + interval_s);
      added.push(null);
    }
    times.push(time);
    added.push(i);
  });
  if (!added.length) return series;

  const surplus = times.findIndex((time) => time > times.at(-1)! - LONGEST_S - interval_s);
  const ids = new Set([...series.cameras.keys(), ...cameras.map(({ id }) => id)]);
  const next: Series = { times: times.slice(surplus), cameras: new Map() };
  for (const id of ids) {
    const before = series.cameras.get(id) ?? emptyCamera(series.times.length);
    const news = cameras.find((camera) => camera.id === id);
    next.cameras.set(id, Object.fromEntries(figures.map((figure) =>
      [figure, [...before[figure], ...added.map((i) => (i === null ? null : news?.[figure][i] ?? null))].slice(surplus)])) as CameraSeries);
  }
  return next;
}

/** Periods in which a camera was not running: pairs of Unix seconds. */
export function outages({ times, cameras }: Series, camera: number): [number, number][] {
  const fps = cameras.get(camera)?.fps ?? [];
  const found: [number, number][] = [];
  fps.forEach((value, i) => {
    if (value !== null) return;
    const to = times[i + 1] ?? times[i]!;
    if (i > 0 && fps[i - 1] === null) found.at(-1)![1] = to;
    else found.push([times[i - 1] ?? times[i]!, to]);
  });
  return found;
}

/** Number of seconds to request so that none is missed; `silent_s`: time since the last answer. */
export const secondsToAsk = (series: Series, silent_s: number) =>
  series.times.length ? Math.min(LONGEST_S, Math.ceil(silent_s) + OVERLAP_S) : LONGEST_S;

/** Index of the sample nearest to a time. */
export function nearestSample(times: readonly number[], time: number): number | null {
  let low = 0;
  let high = times.length - 1;
  if (high < 0) return null;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time) low = middle;
    else high = middle;
  }
  return time - times[low]! <= times[high]! - time ? low : high;
}
