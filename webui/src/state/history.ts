// SPDX-License-Identifier: Apache-2.0
// The last minute of each camera's figures: collected while the panel is open, and completed with the service's
// timeline.
import type { PacketTimeline, Status, Timeline } from '../api/types';

export const HISTORY_MS = 60_000;
/** A second of the timeline that is this close to a status adds nothing. */
const SAME_MS = 600;

export interface Sample {
  /** Time of arrival on the browser's monotonic clock. */
  at: number;
  p50: number;
  p99: number;
}

export interface NetworkSample {
  at: number;
  packetsPerS: number;
}

export class History {
  private readonly cameras = new Map<number, Sample[]>();
  private network: NetworkSample[] = [];

  record(status: Status, at: number): void {
    for (const camera of status.cameras) {
      // A camera that is not running has no latency; its figures are old.
      if (camera.state !== 'running') continue;
      let samples = this.cameras.get(camera.id);
      if (!samples) this.cameras.set(camera.id, (samples = []));
      samples.push({ at, p50: camera.latency_ms.p50, p99: camera.latency_ms.p99 });
      forget(samples, at);
    }
    this.network.push({ at, packetsPerS: status.network.packets_per_s });
    forget(this.network, at);
  }

  /**
   * Adds what the service measured while the panel was not connected. `localTime` converts a Unix time of the service
   * to the browser's monotonic clock.
   */
  fill(timeline: Timeline, localTime: (unixSeconds: number) => number): void {
    const times = timeline.time_s.map(localTime);
    for (const { id, latency_p50_ms, latency_p99_ms } of timeline.cameras) {
      this.cameras.set(id, filled(this.cameras.get(id) ?? [], times, (at, i) => {
        const [p50, p99] = [latency_p50_ms[i], latency_p99_ms[i]];
        return typeof p50 !== 'number' || typeof p99 !== 'number' ? null : { at, p50, p99 };
      }));
    }
  }

  /** The same for packets. */
  fillPackets(timeline: PacketTimeline, localTime: (unixSeconds: number) => number): void {
    this.network = filled(this.network, timeline.time_s.map(localTime), (at, i) => ({ at, packetsPerS: timeline.packets_per_s[i]! }));
  }

  samples(camera: number): readonly Sample[] {
    return this.cameras.get(camera) ?? [];
  }

  networkSamples(): readonly NetworkSample[] {
    return this.network;
  }
}

/** The received samples, completed with missing ones: `missed` returns the sample for a time. */
function filled<Of extends { at: number }>(heard: readonly Of[], times: number[], missed: (at: number, i: number) => Of | null): Of[] {
  const lacking = times.flatMap((at, i) => (heard.some((sample) => Math.abs(sample.at - at) < SAME_MS) ? [] : missed(at, i) ?? []));
  const samples = [...heard, ...lacking].sort((a, b) => a.at - b.at);
  const newest = times.at(-1) ?? -Infinity;
  forget(samples, Math.max(newest, samples.at(-1)?.at ?? newest));
  return samples;
}

function forget(samples: { at: number }[], now: number): void {
  const keep = samples.findIndex((sample) => sample.at >= now - HISTORY_MS);
  if (keep > 0) samples.splice(0, keep);
}
