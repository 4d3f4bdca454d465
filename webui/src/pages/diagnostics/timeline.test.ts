// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { CameraTimeline, Timeline } from '../../api/types';
import { follow, LONGEST_S, nearestSample, noSeries, outages, secondsToAsk } from './timeline';

function cameraTimeline(id: number, fps: (number | null)[]): CameraTimeline {
  const same = (value: number) => fps.map((f) => (f === null ? null : value));
  return {
    id, fps, latency_p50_ms: same(0.4), latency_p99_ms: same(0.8), age_p99_ms: same(3), robots: same(6), balls: same(1),
    dropped: same(0), incomplete: same(0), capped: same(0),
  };
}
const timeline = (time_s: number[], ...cameras: CameraTimeline[]): Timeline => ({ interval_s: 1, time_s, cameras });

describe('a followed timeline', () => {
  it('begins again when the clock was set back', () => {
    const first = follow(noSeries, timeline([5000, 5001], cameraTimeline(0, [70, 71])));
    const next = follow(first, timeline([1401, 1402], cameraTimeline(0, [71, 72])));
    expect(next.times).toEqual([1401, 1402]);
    expect(next.cameras.get(0)!.fps).toEqual([71, 72]);
  });
  it('adds only what is new', () => {
    const first = follow(noSeries, timeline([10, 11, 12], cameraTimeline(0, [70, 71, 72])));
    const next = follow(first, timeline([11, 12, 13], cameraTimeline(0, [1, 2, 73])));
    expect(next.times).toEqual([10, 11, 12, 13]);
    expect(next.cameras.get(0)?.fps).toEqual([70, 71, 72, 73]);
    expect(follow(next, timeline([12, 13], cameraTimeline(0, [1, 2])))).toBe(next);
  });

  it('has holes where a camera did not run, came later or went', () => {
    const first = follow(noSeries, timeline([10, 11], cameraTimeline(0, [70, null])));
    const next = follow(first, timeline([12, 13], cameraTimeline(1, [60, 61])));
    expect(next.cameras.get(0)?.fps).toEqual([70, null, null, null]);
    expect(next.cameras.get(0)?.robots).toEqual([6, null, null, null]);
    expect(next.cameras.get(1)?.fps).toEqual([null, null, 60, 61]);
  });

  it('has a hole where time is missing', () => {
    const series = follow(follow(noSeries, timeline([10], cameraTimeline(0, [70]))), timeline([20, 21], cameraTimeline(0, [71, 72])));
    expect(series.times).toEqual([10, 11, 20, 21]);
    expect(series.cameras.get(0)?.fps).toEqual([70, null, 71, 72]);
  });

  it('keeps ten minutes', () => {
    const times = Array.from({ length: 500 }, (_, i) => 1000 + i);
    const later = times.map((time) => time + 500);
    const series = follow(follow(noSeries, timeline(times, cameraTimeline(0, times))), timeline(later, cameraTimeline(0, later)));
    expect(series.times.length).toBe(LONGEST_S + 1);
    expect(series.times.at(-1)).toBe(1999);
    expect(series.cameras.get(0)?.fps).toEqual(series.times);
  });
});

it('knows when a camera did not run', () => {
  const series = follow(noSeries, timeline([10, 11, 12, 13, 14, 15, 16], cameraTimeline(0, [null, 70, 0, null, null, 70, null]), cameraTimeline(1, Array(7).fill(60))));
  expect(outages(series, 0)).toEqual([[10, 11], [12, 15], [15, 16]]);
  expect(outages(series, 1)).toEqual([]);
  expect(outages(series, 7)).toEqual([]);
});

it('asks for no more than it lacks', () => {
  expect(secondsToAsk(noSeries, 0)).toBe(LONGEST_S);
  const series = follow(noSeries, timeline([10], cameraTimeline(0, [70])));
  expect(secondsToAsk(series, 1.2)).toBe(7);
  expect(secondsToAsk(series, 4000)).toBe(LONGEST_S);
});

it('finds the nearest sample', () => {
  expect(nearestSample([], 5)).toBeNull();
  expect(nearestSample([10], 5)).toBe(0);
  expect([9, 10.4, 10.6, 12.9, 99].map((time) => nearestSample([10, 11, 12, 13], time))).toEqual([0, 0, 1, 3, 3]);
});
