// SPDX-License-Identifier: Apache-2.0
// The quality of the link to the service: whether statuses arrive late or are dropped. Uses two clocks that nobody
// sets: the service's uptime and the browser's performance.now().

/** The service makes a status twice a second; on a slow link, newer ones replace those that wait. */
const SLOW_GAP_MS = 1200;
const GOOD_GAP_MS = 800;
/** Delay relative to the fastest status of this connection. */
const SLOW_LATE_MS = 600;
const GOOD_LATE_MS = 250;
/** Period that is judged, with at least a few statuses. */
const WINDOW_MS = 6000;
const FEWEST = 3;
/** The two clocks drift apart by no more than this share; the fastest status is forgotten at the same rate. */
const DRIFT = 1e-4;

interface Heard {
  at: number;
  uptimeMs: number;
  lateMs: number;
}

export class LinkMeter {
  private recent: Heard[] = [];
  /** The service's uptime minus the local clock, at the fastest status. */
  private ahead = -Infinity;
  private slow = false;

  /** A new connection: the link may be different, and the service may have restarted. */
  opened(): void {
    this.recent = [];
    this.ahead = -Infinity;
  }

  /** Records a status with the service's uptime that arrived at `at`. */
  heard(uptimeMs: number, at: number): void {
    const last = this.recent.at(-1);
    if (last && uptimeMs < last.uptimeMs) this.opened();
    const ahead = uptimeMs - at;
    this.ahead = Math.max(ahead, this.ahead - (last ? (at - last.at) * DRIFT : 0));
    this.recent.push({ at, uptimeMs, lateMs: this.ahead - ahead });
    while (this.recent.length > FEWEST && this.recent[0]!.at < at - WINDOW_MS) this.recent.shift();
    if (this.recent.length < FEWEST) return;
    const gapMs = (uptimeMs - this.recent[0]!.uptimeMs) / (this.recent.length - 1);
    const late = this.recent.map(({ lateMs }) => lateMs).sort((a, b) => a - b);
    const lateMs = late[Math.floor(late.length / 2)]!;
    if (gapMs > SLOW_GAP_MS || lateMs > SLOW_LATE_MS) this.slow = true;
    else if (gapMs < GOOD_GAP_MS && lateMs < GOOD_LATE_MS) this.slow = false;
  }

  /** Whether statuses have arrived late or rarely. */
  get isSlow(): boolean { return this.slow; }

  /** Estimate of the service's current uptime; null before its first status. */
  uptimeMs(at: number): number | null {
    return this.ahead === -Infinity ? null : at + this.ahead;
  }
}
