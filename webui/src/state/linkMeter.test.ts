// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { LinkMeter } from './linkMeter';

/** Statuses made at `made`, in ms of uptime, each delayed by `lateMs`. */
function hear(meter: LinkMeter, made: number[], lateMs: (i: number) => number): void {
  made.forEach((uptime, i) => meter.heard(uptime, 1000 + uptime + lateMs(i)));
}
const every = (ms: number, count: number, from = 0) => Array.from({ length: count }, (_, i) => from + i * ms);

describe('LinkMeter', () => {
  it('calls a link good whose statuses come as they are made', () => {
    const meter = new LinkMeter();
    hear(meter, every(500, 20), () => 20);
    expect(meter.isSlow).toBe(false);
  });
  it('calls it slow when statuses are left out, also where they all come equally late', () => {
    const meter = new LinkMeter();
    hear(meter, every(1500, 4), () => 900);
    expect(meter.isSlow).toBe(true);
  });
  it('calls it slow when they come later than the first ones did', () => {
    const meter = new LinkMeter();
    hear(meter, every(500, 30), (i) => (i < 10 ? 20 : 900));
    expect(meter.isSlow).toBe(true);
  });
  it('does not mind one that is late', () => {
    const meter = new LinkMeter();
    hear(meter, every(500, 20), (i) => (i === 12 ? 2000 : 20));
    expect(meter.isSlow).toBe(false);
  });
  it('calls it good again only when all is well again', () => {
    const meter = new LinkMeter();
    hear(meter, every(1500, 6), () => 20);
    hear(meter, every(1000, 10, 10_000), () => 20);
    expect(meter.isSlow).toBe(true);
    hear(meter, every(500, 20, 30_000), () => 20);
    expect(meter.isSlow).toBe(false);
  });
  it('goes by no clock that can be set, and begins again with another run of the service', () => {
    const meter = new LinkMeter();
    hear(meter, every(500, 20, 1e7), () => 20);
    meter.heard(100, 50_000);
    meter.heard(600, 50_500);
    meter.heard(1100, 51_000);
    expect(meter.isSlow).toBe(false);
    expect(meter.uptimeMs(51_500)).toBeCloseTo(1600, 0);
  });
  it('knows nothing before the first status', () => expect(new LinkMeter().uptimeMs(5)).toBeNull());
});
