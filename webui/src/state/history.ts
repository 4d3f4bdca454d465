// SPDX-License-Identifier: Apache-2.0
// The last minute of each camera's figures, gathered while the panel is open.
import type { Status } from '../api/types';

export const HISTORY_MS = 60_000;

export interface Sample {
  /** When it arrived, on the browser's monotonic clock. */
  at: number;
  fps: number;
  p50: number;
  p99: number;
  dropped: number;
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
      // A camera that does not run has no latency; its figures are those of before.
      if (camera.state !== 'running') continue;
      let samples = this.cameras.get(camera.id);
      if (!samples) this.cameras.set(camera.id, (samples = []));
      samples.push({
        at, fps: camera.fps, p50: camera.latency_ms.p50, p99: camera.latency_ms.p99,
        dropped: camera.frames_dropped,
      });
      forget(samples, at);
    }
    this.network.push({ at, packetsPerS: status.network.packets_per_s, sendErrors: status.network.send_errors });
    forget(this.network, at);
  }

  samples(camera: number): readonly Sample[] {
    return this.cameras.get(camera) ?? [];
  }

  /** Pictures dropped within the last minute. */
  dropped(camera: number): number {
    return growth(this.samples(camera).map((sample) => sample.dropped));
  }

  bestFps(camera: number): number {
    return this.samples(camera).reduce((best, sample) => Math.max(best, sample.fps), 0);
  }

  networkSamples(): readonly NetworkSample[] {
    return this.network;
  }

  newSendErrors(): number {
    return growth(this.network.map(({ sendErrors }) => sendErrors));
  }
}

/** A count that stands this many samples long is believed: a frame still in work may pass for a dropped one. */
const SETTLED = 3;

/** How much a counter grew over its samples. A counter that fell began anew and is counted from there. */
function growth(counts: number[]): number {
  let sum = 0;
  let last: number | null = null;
  for (let i = 0; i + SETTLED <= counts.length; i++) {
    const settled = Math.min(...counts.slice(i, i + SETTLED));
    if (last !== null && settled > last) sum += settled - last;
    last = settled;
  }
  return sum;
}

function forget(samples: { at: number }[], now: number): void {
  const keep = samples.findIndex((sample) => sample.at >= now - HISTORY_MS);
  if (keep > 0) samples.splice(0, keep);
}
