// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { CameraTimeline, Status, Timeline } from '../api/types';
import { History, HISTORY_MS } from './history';

const status = (id: number, p50: number) => ({
  cameras: [{ id, state: 'running', latency_ms: { p50, p99: p50 * 2 } }], network: { packets_per_s: 0, send_errors: 0 },
}) as unknown as Status;

const timeline = (times: number[], p50: (number | null)[], id = 0): Timeline => ({
  interval_s: 1, time_s: times,
  cameras: [{ id, latency_p50_ms: p50, latency_p99_ms: p50.map((value) => (value === null ? null : value * 2)) } as CameraTimeline],
});
/** The service's second 1000 corresponds to 500 000 ms here. */
const localTime = (time: number) => 500_000 + 1000 * (time - 1000);

describe('the history', () => {
  it('is full as soon as the timeline came', () => {
    const history = new History();
    history.record(status(0, 5), localTime(1003));
    history.fill(timeline([1000, 1001, 1002, 1003], [1, null, 3, 4]), localTime);
    expect(history.samples(0)).toEqual([
      { at: localTime(1000), p50: 1, p99: 2 }, { at: localTime(1002), p50: 3, p99: 6 }, { at: localTime(1003), p50: 5, p99: 10 },
    ]);
  });

  it('fills the gap of a lost connection and keeps what was heard', () => {
    const history = new History();
    for (const second of [1000, 1001, 1010]) history.record(status(0, second), localTime(second) + 20);
    const times = Array.from({ length: 11 }, (_, i) => 1000 + i);
    history.fill(timeline(times, times.map(() => 7)), localTime);
    const samples = history.samples(0);
    expect(samples.map(({ at }) => Math.round(at / 1000))).toEqual(times.map((time) => localTime(time) / 1000));
    expect(samples.filter(({ p50 }) => p50 === 7)).toHaveLength(8);
  });

  it('is full of packets, too', () => {
    const history = new History();
    history.record({ ...status(0, 5), network: { packets_per_s: 61, send_errors: 0 } } as unknown as Status, localTime(1002));
    history.fillPackets({ time_s: [1000, 1001, 1002], packets_per_s: [58, 59, 60] }, localTime);
    expect(history.networkSamples()).toEqual([{ at: localTime(1000), packetsPerS: 58 }, { at: localTime(1001), packetsPerS: 59 }, { at: localTime(1002), packetsPerS: 61 }]);
  });

  it('forgets what is older than a minute', () => {
    const history = new History();
    const times = Array.from({ length: 100 }, (_, i) => 1000 + i);
    history.fill(timeline(times, times), localTime);
    const samples = history.samples(0);
    expect(samples.at(-1)!.at - samples[0]!.at).toBeLessThanOrEqual(HISTORY_MS);
    expect(samples).toHaveLength(61);
  });
});
