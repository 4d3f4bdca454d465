// SPDX-License-Identifier: Apache-2.0
// The last minute of each camera's figures: gathered while the panel is open, and filled from what the service keeps.
import type { Status, Timeline } from '../api/types';

export const HISTORY_MS = 60_000;
/** A second of the timeline that is as near to a status says nothing new. */
const SAME_MS = 600;

export interface Sample {
  /** When it arrived, on the browser's monotonic clock. */
  at: number;
  p50: number;
  p99: number;
}

export interface NetworkSample {
  at: number;
  packetsPerS: number;
  sendErrors: number;
}

export class History {
  private readonly cameras = new Map<number, Sample[]>();
  private readonly network: NetworkSample[] = [];

  record(status: Status, at: number): void {
    for (const camera of status.cameras) {
      // A camera that does not run has no latency; its figures are old.
      if (camera.state !== 'running') continue;
      let samples = this.cameras.get(camera.id);
      if (!samples) this.cameras.set(camera.id, (samples = []));
      samples.push({ at, p50: camera.latency_ms.p50, p99: camera.latency_ms.p99 });
      forget(samples, at);
    }
    this.network.push({ at, packetsPerS: status.network.packets_per_s, sendErrors: status.network.send_errors });
    forget(this.network, at);
  }

  /**
   * Adds what the service measured while nobody was there to hear it. `localTime` tells when a moment of the service's
   * clock was, on the browser's monotonic one.
   */
  fill(timeline: Timeline, localTime: (unixSeconds: number) => number): void {
    const newest = localTime(timeline.time_s.at(-1) ?? 0);
    for (const { id, latency_p50_ms, latency_p99_ms } of timeline.cameras) {
      const heard = this.cameras.get(id) ?? [];
      const missed = timeline.time_s.flatMap((time, i): Sample[] => {
        const [p50, p99] = [latency_p50_ms[i], latency_p99_ms[i]];
        const at = localTime(time);
        const isHeard = heard.some((sample) => Math.abs(sample.at - at) < SAME_MS);
        return typeof p50 !== 'number' || typeof p99 !== 'number' || isHeard ? [] : [{ at, p50, p99 }];
      });
      const samples = [...heard, ...missed].sort((a, b) => a.at - b.at);
      forget(samples, Math.max(newest, samples.at(-1)?.at ?? newest));
      this.cameras.set(id, samples);
    }
  }

  samples(camera: number): readonly Sample[] {
    return this.cameras.get(camera) ?? [];
  }

  networkSamples(): readonly NetworkSample[] {
    return this.network;
  }
}

function forget(samples: { at: number }[], now: number): void {
  const keep = samples.findIndex((sample) => sample.at >= now - HISTORY_MS);
  if (keep > 0) samples.splice(0, keep);
}
