// SPDX-License-Identifier: Apache-2.0
// What the strip on the Overview says, and when it calls something a warning or a fault.
import type { CameraStatus, Status } from '../api/types';
import type { SeenBall, SeenRobot } from '../field/merge';
import { figure, latencyMs, plural } from '../format';
import type { History } from '../state/history';

export type Level = 'ok' | 'warn' | 'bad';

export interface Fact {
  key: 'cameras' | 'latency' | 'fps' | 'robots' | 'ball' | 'network';
  label: string;
  value: string;
  unit: string;
  note: string;
  level: Level;
}

export const limits = {
  /** Worst p99 from capture to socket, milliseconds. */
  latencyWarnMs: 5,
  latencyBadMs: 15,
  /** A camera slower than this share of its best in the last minute has lost speed. */
  fpsShare: 0.9,
};

export interface FactsInput {
  status: Status;
  history: History;
  robots: SeenRobot[];
  balls: SeenBall[];
}

type Verdict = Pick<Fact, 'value' | 'unit' | 'note' | 'level'>;

const names = (cameras: CameraStatus[]) =>
  `${cameras.length > 1 ? 'cameras' : 'camera'} ${cameras.map((camera) => camera.id).join(', ')}`;

function cameras({ status }: FactsInput): Verdict {
  const all = status.cameras;
  const running = all.filter((camera) => camera.state === 'running');
  const verdict = (level: Level, note: string): Verdict => ({ value: String(running.length), unit: `of ${all.length}`, note, level });
  const lost = all.filter((camera) => camera.state === 'lost');
  const idle = all.filter((camera) => camera.state === 'opening' || camera.state === 'ended');
  const blind = all.filter((camera) => !camera.calibration);
  if (!all.length) return verdict('bad', 'none is set up');
  if (lost.length) return verdict('bad', `${names(lost)} lost`);
  if (idle.length) return verdict('warn', `${names(idle)} ${idle[0]!.state}`);
  if (blind.length) return verdict('warn', `${names(blind)} not calibrated`);
  return verdict('ok', 'all running');
}

function latency({ status }: FactsInput): Verdict {
  const running = status.cameras.filter((camera) => camera.state === 'running');
  if (!running.length) return { value: '–', unit: 'ms', note: 'no camera runs', level: 'bad' };
  const worst = Math.max(...running.map((camera) => camera.latency_ms.p99));
  const level = worst > limits.latencyBadMs ? 'bad' : worst > limits.latencyWarnMs ? 'warn' : 'ok';
  return { value: latencyMs(worst), unit: 'ms', note: `worst p99, limit ${limits.latencyWarnMs} ms`, level };
}

function frameRate({ status, history }: FactsInput): Verdict {
  const running = status.cameras.filter((camera) => camera.state === 'running');
  if (!running.length) return { value: '–', unit: 'fps', note: 'no camera runs', level: 'bad' };
  const slowest = running.reduce((a, b) => (b.fps < a.fps ? b : a));
  const verdict = (level: Level, note: string): Verdict => ({ value: slowest.fps.toFixed(1), unit: 'fps', note, level });
  if (slowest.fps === 0) return verdict('bad', `${names([slowest])} sends nothing`);
  const slowed = running.find((camera) => camera.fps < limits.fpsShare * history.bestFps(camera.id));
  if (slowed) return verdict('warn', `${names([slowed])} did ${history.bestFps(slowed.id).toFixed(1)}`);
  const dropped = running.reduce((sum, camera) => sum + history.dropped(camera.id), 0);
  if (dropped) return verdict('warn', `${figure(dropped)} dropped in 60 s`);
  return verdict('ok', 'no drops');
}

function robots(input: FactsInput): Verdict {
  const count = (team: string) => new Set(input.robots.filter((r) => r.team === team).map((r) => r.id)).size;
  const yellow = count('yellow');
  const blue = count('blue');
  const value = String(yellow + blue);
  if (!yellow && !blue) return { value, unit: '', note: 'none seen', level: 'warn' };
  const note = `${yellow} yellow, ${blue} blue`;
  if (input.robots.length > yellow + blue) return { value, unit: '', note: `${note}, one in two places`, level: 'warn' };
  return { value, unit: '', note, level: 'ok' };
}

function ball({ balls }: FactsInput): Verdict {
  const value = String(balls.length);
  if (!balls.length) return { value, unit: '', note: 'not seen', level: 'warn' };
  if (balls.length > 1) return { value, unit: '', note: 'more than one seen', level: 'warn' };
  return { value, unit: '', note: `seen by camera ${balls[0]!.camera}`, level: 'ok' };
}

function network({ status, history }: FactsInput): Verdict {
  const { error, packets_per_s, group, port } = status.network;
  const verdict = (level: Level, note: string): Verdict => ({ value: figure(packets_per_s), unit: 'pkt/s', note, level });
  if (error) return verdict('bad', error);
  const failed = history.newSendErrors();
  if (failed) return verdict('bad', `${plural(failed, 'send error')} in 60 s`);
  if (packets_per_s === 0) return verdict('bad', 'nothing is sent');
  return verdict('ok', `to ${group}:${port}`);
}

export function facts(input: FactsInput): Fact[] {
  return [
    { key: 'cameras', label: 'Cameras', ...cameras(input) },
    { key: 'latency', label: 'Latency', ...latency(input) },
    { key: 'fps', label: 'Frame rate', ...frameRate(input) },
    { key: 'robots', label: 'Robots', ...robots(input) },
    { key: 'ball', label: 'Ball', ...ball(input) },
    { key: 'network', label: 'Network', ...network(input) },
  ];
}

/** The strip before or without news: every label, no number. */
export const unknownFacts: Pick<Fact, 'key' | 'label'>[] = [
  { key: 'cameras', label: 'Cameras' },
  { key: 'latency', label: 'Latency' },
  { key: 'fps', label: 'Frame rate' },
  { key: 'robots', label: 'Robots' },
  { key: 'ball', label: 'Ball' },
  { key: 'network', label: 'Network' },
];
