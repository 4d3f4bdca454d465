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

export class History {
  private readonly cameras = new Map<number, Sample[]>();
  private sendErrors: { at: number; count: number }[] = [];

  record(status: Status, at: number): void {
    for (const camera of status.cameras) {
      // A camera that does not run has no latency; its figures are those of before.
      if (camera.state !== 'running') continue;
      let samples = this.cameras.get(camera.id);
      if (!samples) this.cameras.set(camera.id, (samples = []));
      const last = samples[samples.length - 1];
      // The daemon was restarted: its counters began again, so the old ones compare to nothing.
      if (last && last.dropped > camera.frames_dropped) samples.length = 0;
      samples.push({
        at, fps: camera.fps, p50: camera.latency_ms.p50, p99: camera.latency_ms.p99,
        dropped: camera.frames_dropped,
      });
      forget(samples, at);
    }
    const lastErrors = this.sendErrors[this.sendErrors.length - 1];
    if (lastErrors && lastErrors.count > status.network.send_errors) this.sendErrors = [];
    this.sendErrors.push({ at, count: status.network.send_errors });
    forget(this.sendErrors, at);
  }

  samples(camera: number): readonly Sample[] {
    return this.cameras.get(camera) ?? [];
  }

  /** Pictures dropped within the last minute. */
  dropped(camera: number): number {
    const samples = this.samples(camera);
    return samples.length ? samples[samples.length - 1]!.dropped - samples[0]!.dropped : 0;
  }

  bestFps(camera: number): number {
    return this.samples(camera).reduce((best, sample) => Math.max(best, sample.fps), 0);
  }

  newSendErrors(): number {
    const errors = this.sendErrors;
    return errors.length ? errors[errors.length - 1]!.count - errors[0]!.count : 0;
  }
}

function forget(samples: { at: number }[], now: number): void {
  const keep = samples.findIndex((sample) => sample.at >= now - HISTORY_MS);
  if (keep > 0) samples.splice(0, keep);
}
