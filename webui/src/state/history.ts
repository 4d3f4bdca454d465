// SPDX-License-Identifier: Apache-2.0
// The last minute of each camera's figures, gathered while the panel is open.
import type { Status } from '../api/types';

export const HISTORY_MS = 60_000;

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
