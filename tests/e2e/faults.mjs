// SPDX-License-Identifier: Apache-2.0
// The real service under faults: it is killed, its disk is full, its clock is set.
//   SSLV_DAEMON        the service; default: the release build
//   SSLV_FAULT_TRIES   factor for the number of repetitions of each fault; default: 1, which takes seconds
//   SSLV_FAULT_TABLE   a file to which each fault's row of a table in Markdown is appended
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { appendFileSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { request } from 'node:http';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { createInterface } from 'node:readline';
import { detectionOf } from './protobuf.mjs';
import { becomes, DAEMON, freeUdpPort, listenTo, root } from './service.mjs';

export const CLOCK = join(DAEMON, '../../lib/shifted_clock.so');
export const HUNG_DISK = join(DAEMON, '../../lib/hung_disk.so');
/** An environment that preloads this library. By name, as LD_PRELOAD accepts no path with a space. */
export const preload = (library) => ({ LD_PRELOAD: basename(library), LD_LIBRARY_PATH: dirname(library) });
/** Set by ./run faults, on an otherwise idle machine: only there are durations asserted. */
export const IS_TIMED = Boolean(process.env.SSLV_FAULT_TABLE);
const FACTOR = Number(process.env.SSLV_FAULT_TRIES ?? 1);
export const tries = (few, many) => Math.max(1, Math.min(many, Math.round(few * FACTOR)));

/** Why this process cannot create its own namespaces; false if it can. */
export function cannotUnshare() {
  if (process.getuid() !== 0) return 'needs root, to make a file system or network of its own';
  try {
    execFileSync('unshare', ['--mount', '--net', 'true'], { stdio: 'pipe' });
    return false;
  } catch (error) {
    return `no namespaces here: ${String(error.stderr ?? error.message).trim()}`;
  }
}

/**
 * Adds a row to the table: number of repetitions, how much was lost (frames, or confirmed saves; null: not applicable),
 * and the recovery times.
 */
export function report(fault, count, lost, times_ms = []) {
  const sorted = [...times_ms].sort((a, b) => a - b);
  const ms = (value) => (value === undefined ? '' : value < 10 ? value.toFixed(1) : value.toFixed(0));
  const row = `| ${fault} | ${count} | ${lost ?? '–'} | ${ms(sorted[Math.floor((sorted.length - 1) / 2)])} | ${ms(sorted.at(-1))} |`;
  if (process.env.SSLV_FAULT_TABLE) appendFileSync(process.env.SSLV_FAULT_TABLE, `${row}\n`);
  console.log(row);
}

/** A cheap camera: 156x116 pixels, `rate` frames per second. */
export function smallCamera(id, rate = 30) {
  const [camera] = JSON.parse(readFileSync(join(root, 'config/demo.json'), 'utf8')).cameras;
  const scale = 0.2;
  const { focal_length: f, principal_point_x: x, principal_point_y: y } = camera.calibration;
  return {
    ...camera, id,
    source: { ...camera.source, width: 156, height: 116, frame_rate_hz: rate },
    calibration: { ...camera.calibration, focal_length: f * scale, principal_point_x: x * scale, principal_point_y: y * scale, pixel_image_width: 156, pixel_image_height: 116 },
  };
}

export class FaultyService {
  /** Does not start the service yet. `wrap`: a program with arguments that execs the service. */
  constructor(group, { cameras = [smallCamera(0)], environment = {}, wrap = [] } = {}) {
    this.folder = mkdtempSync(join(tmpdir(), 'ssl-visiond-faults.'));
    this.state = join(this.folder, 'state');
    this.settingsFile = join(this.folder, 'admin.json');
    this.environment = environment;
    this.wrap = wrap;
    // Without the image ring, which is allocated some seconds after the start: tests check that memory does not grow.
    this.settings = {
      network: { vision: { group, interface: 'lo' }, referee: { enabled: false } }, panel: { port: 0 }, recording: { last_seconds: { memory_mb: 0 } }, cameras,
    };
    this.log = [];
    this.receivers = [];
  }

  async prepare() {
    this.settings.network.vision.port = await freeUdpPort();
    this.writeSettings();
  }

  writeSettings(text = JSON.stringify(this.settings)) {
    writeFileSync(this.settingsFile, text);
  }

  /** Returns when the process exists, before it is ready. */
  spawn() {
    const [program, ...words] = [...this.wrap, DAEMON, '--config', this.settingsFile, '--panel', join(root, 'webui/dist')];
    this.log = [];
    this.process = spawn(program, words, { env: { ...process.env, STATE_DIRECTORY: this.state, ...this.environment }, stdio: ['ignore', 'ignore', 'pipe'] });
    const daemon = this.process;
    const { log } = this;
    this.ended = new Promise((resolve) => { daemon.once('close', (code, signal) => resolve({ code, signal })); });
    this.ready = Promise.race([
      new Promise((resolve) => {
        createInterface(daemon.stderr).on('line', (line) => {
          log.push(line);
          const port = /panel on port (\d+)/.exec(line)?.[1];
          if (port) resolve(Number(port));
        });
      }),
      this.ended.then(({ code, signal }) => { throw new Error(`it ended (${code ?? signal}) before it was ready:\n${log.join('\n')}`); }),
    ]);
    this.ready.catch(() => {});
  }

  /** Starts the service; returns the milliseconds until it was ready. */
  async start() {
    const began = performance.now();
    this.spawn();
    this.port = await this.ready;
    return performance.now() - began;
  }

  kill(signal) {
    this.process.kill(signal);
    return this.ended;
  }

  async stop() {
    const { code, signal } = await this.kill('SIGTERM');
    assert.deepEqual([code, signal], [0, null], this.log.slice(-20).join('\n'));
  }

  async remove() {
    for (const receiver of this.receivers.splice(0)) receiver.close();
    if (this.process && this.process.exitCode === null && this.process.signalCode === null) await this.kill('SIGKILL');
    rmSync(this.folder, { recursive: true, force: true });
  }

  /** Sends a request on a connection of its own: {status, json}; throws if the answer is incomplete. */
  ask(method, path, body) {
    return new Promise((resolve, reject) => {
      const text = body === undefined ? '' : JSON.stringify(body);
      const asked = request({ port: this.port, host: '127.0.0.1', method, path: `/${path}`, agent: false, headers: { 'Content-Length': Buffer.byteLength(text) } }, (answer) => {
        const parts = [];
        answer.on('data', (part) => parts.push(part));
        answer.on('error', reject);
        answer.on('end', () => {
          if (!answer.complete) return reject(new Error('cut off'));
          const all = Buffer.concat(parts).toString();
          try {
            resolve({ status: answer.statusCode, json: /json/.test(answer.headers['content-type']) ? JSON.parse(all) : all });
          } catch (error) {
            reject(error);
          }
        });
      });
      asked.on('error', reject);
      asked.end(text);
    });
  }

  async good(method, path, body) {
    const { status, json } = await this.ask(method, path, body);
    assert.equal(status, 200, `${method} ${path}: ${JSON.stringify(json).slice(0, 500)}`);
    return json;
  }

  get = (path) => this.good('GET', path);
  set = (path, value) => this.ask('PATCH', 'api/settings', [{ op: 'replace', path, value }]);
  status = () => this.get('api/status');
  alerts = async () => (await this.status()).alerts.map(({ id }) => id);
  alertGoes = (wanted) => becomes(this.alerts, (ids) => !ids.includes(wanted));
  alertComes = async (wanted) => (await becomes(this.status, ({ alerts }) => alerts.some(({ id }) => id === wanted))).alerts.find(({ id }) => id === wanted);

  /** Names of the files in the state folder and its subfolders; throws if a JSON file does not parse. */
  stateFiles(folder = this.state) {
    return readdirSync(folder, { recursive: true }).filter((name) => {
      if (name.endsWith('.json')) JSON.parse(readFileSync(join(folder, name), 'utf8'));
      return true;
    });
  }

  /** Collects the detection packets: {camera, number, capture_s, sent_s, at_ms}. */
  async listen(address = '127.0.0.1') {
    const { group, port } = this.settings.network.vision;
    const frames = [];
    const receiver = await listenTo(group, port, (packet) => {
      const frame = detectionOf(packet);
      if (frame) frames.push({ number: frame.frame_number, capture_s: frame.t_capture, sent_s: frame.t_sent, camera: frame.camera_id, at_ms: performance.now() });
    }, address);
    this.receivers.push(receiver);
    const of = (camera) => frames.filter((frame) => frame.camera === camera);
    return {
      frames,
      of,
      /** Waits for so many more frames of a camera. */
      async more(camera, count) {
        const before = of(camera).length;
        await becomes(() => of(camera).length, (now) => now >= before + count);
      },
      /**
       * Number of frames that pipelines produced but that did not arrive, counted from the first one that did; of one
       * camera or of all. Does not count packets that this process was too slow to receive.
       */
      lost(...cameras) {
        const gaps = cameras.flatMap((camera) => of(camera).slice(1).map(({ number }, i) => Math.max(0, number - of(camera)[i].number - 1)));
        return Math.max(0, gaps.reduce((sum, gap) => sum + gap, 0) - receiver.missed());
      },
      close: () => {
        this.receivers = this.receivers.filter((other) => other !== receiver);
        receiver.close();
      },
    };
  }
}
