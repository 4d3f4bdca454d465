// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Status } from '../api/types';
import { History } from '../state/history';
import { camera, robot, status } from '../testing/samples';
import { facts, type FactsInput } from './facts';

const ball = { camera: 0, x: 0, y: 0, confidence: 0.9, area: 40, pixel_x: 0, pixel_y: 0 };
const both = [{ ...robot(), camera: 0 }, { ...robot({ team: 'blue' }), camera: 1 }];

function judge(now: Status, changes: Partial<FactsInput> = {}) {
  const history = new History();
  history.record(now, 0);
  const list = facts({ status: now, history, robots: both, balls: [ball], ...changes });
  return Object.fromEntries(list.map((fact) => [fact.key, fact]));
}

function dropped(counts: number[]): number {
  const history = new History();
  counts.forEach((frames_dropped, i) => history.record(status({ cameras: [camera({ frames_dropped })] }), i * 500));
  return history.dropped(0);
}

describe('facts', () => {
  it('is content with a field in order', () => {
    const list = judge(status());
    expect(Object.values(list).map((fact) => fact.level)).toEqual(['ok', 'ok', 'ok', 'ok', 'ok', 'ok']);
    expect(list.cameras).toMatchObject({ value: '2', unit: 'of 2', note: 'all running' });
    expect(list.robots).toMatchObject({ value: '2', note: '1 yellow, 1 blue' });
  });

  it('names the lost camera first', () => {
    const list = judge(status({ cameras: [camera({ state: 'opening' }), camera({ id: 1, state: 'lost' })] }));
    expect(list.cameras).toMatchObject({ value: '0', level: 'bad', note: 'camera 1 lost' });
    expect(list.latency).toMatchObject({ value: '–', level: 'bad' });
  });

  it('warns of cameras that do not run or are not calibrated', () => {
    expect(judge(status({ cameras: [camera({ state: 'ended' })] })).cameras).toMatchObject({ level: 'warn', note: 'camera 0 ended' });
    expect(judge(status({ cameras: [camera({ calibration: null })] })).cameras).toMatchObject({ level: 'warn', note: 'camera 0 not calibrated' });
    expect(judge(status({ cameras: [] })).cameras).toMatchObject({ level: 'bad', value: '0', unit: 'of 0' });
  });

  it('judges the worst p99', () => {
    const at = (p99: number) => judge(status({ cameras: [camera(), camera({ id: 1, latency_ms: { p50: 1, p99 } })] })).latency;
    expect(at(5)).toMatchObject({ level: 'ok', value: '5.00' });
    expect(at(5.1)).toMatchObject({ level: 'warn' });
    expect(at(16)).toMatchObject({ level: 'bad', value: '16.0' });
  });

  it('warns when a camera slows down or drops, but not of drops long ago', () => {
    const history = new History();
    const at = (fps: number, frames_dropped: number) => status({ cameras: [camera({ fps, frames_dropped })] });
    history.record(at(60, 100), 0);
    history.record(at(50, 100), 1000);
    expect(judge(at(50, 100), { history }).fps).toMatchObject({ level: 'warn', note: 'camera 0 did 60.0' });
    for (const time of [2000, 2500, 3000]) history.record(at(60, 103), time);
    expect(judge(at(60, 103), { history }).fps).toMatchObject({ level: 'warn', note: '3 dropped in 60 s' });
    for (const time of [70_000, 70_500, 71_000]) history.record(at(60, 103), time);
    expect(judge(at(60, 103), { history }).fps).toMatchObject({ level: 'ok' });
  });

  it('starts to count again after the daemon restarted', () => {
    expect(dropped([500, 500, 500, 0, 0, 0])).toBe(0);
    expect(dropped([500, 500, 500, 0, 0, 0, 2, 2, 2])).toBe(2);
  });

  it('does not take a frame in work for a dropped one', () => {
    expect(dropped([0, 0, 0, 1, 0, 0, 0, 1, 1, 0])).toBe(0);
  });

  it('counts robots once and sees one in two places', () => {
    const twice = [{ ...robot({ x: -900 }), camera: 0 }, { ...robot({ x: 900 }), camera: 1 }];
    expect(judge(status(), { robots: twice }).robots).toMatchObject({ value: '1', level: 'warn' });
    expect(judge(status(), { robots: [] }).robots).toMatchObject({ level: 'warn', note: 'none seen' });
  });

  it('wants one ball', () => {
    expect(judge(status(), { balls: [] }).ball).toMatchObject({ level: 'warn', value: '0' });
    expect(judge(status(), { balls: [ball, ball] }).ball).toMatchObject({ level: 'warn', value: '2' });
  });

  it('tells of a network that does not send', () => {
    const network = status().network;
    expect(judge(status({ network: { ...network, error: 'no such interface' } })).network).toMatchObject({ level: 'bad', note: 'no such interface' });
    expect(judge(status({ network: { ...network, packets_per_s: 0 } })).network).toMatchObject({ level: 'bad', note: 'nothing is sent' });
    const history = new History();
    const failing = status({ network: { ...network, send_errors: 1 } });
    [status(), status(), status(), failing, failing, failing].forEach((now, i) => history.record(now, i * 500));
    expect(judge(failing, { history }).network).toMatchObject({ level: 'bad', note: '1 send error in 60 s' });
  });
});
