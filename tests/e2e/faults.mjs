// SPDX-License-Identifier: Apache-2.0
// The real service as one that things happen to: it is killed, its disk is full, its clock is set.
//   SSLV_DAEMON        the service; default: the release build
//   SSLV_FAULT_TRIES   how often each fault is made to happen, as a factor; default 1, which takes seconds
//   SSLV_FAULT_TABLE   a file to which each fault's row of a table in Markdown is added
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
/** An environment in which a program loads this library first. By its name: LD_PRELOAD takes no path with a space. */
export const preload = (library) => ({ LD_PRELOAD: basename(library), LD_LIBRARY_PATH: dirname(library) });
/** Asked by ./run faults, on a machine that does nothing else: how long it takes is then a part of the verdict. */
export const IS_TIMED = Boolean(process.env.SSLV_FAULT_TABLE);
const FACTOR = Number(process.env.SSLV_FAULT_TRIES ?? 1);
export const tries = (few, many) => Math.max(1, Math.min(many, Math.round(few * FACTOR)));

/** Why the caller cannot make namespaces of its own; false when it can. */
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
 * Adds a row to the table: how often, how much was counted as lost (frames, or answered saves; null: nothing was there
 * to be counted), how long it took to be well again.
 */
export function report(fault, count, lost, times_ms = []) {
  const sorted = [...times_ms].sort((a, b) => a - b);
  const ms = (value) => (value === undefined ? '' : value < 10 ? value.toFixed(1) : value.toFixed(0));
  const row = `| ${fault} | ${count} | ${lost ?? '–'} | ${ms(sorted[Math.floor((sorted.length - 1) / 2)])} | ${ms(sorted.at(-1))} |`;
  if (process.env.SSLV_FAULT_TABLE) appendFileSync(process.env.SSLV_FAULT_TABLE, `${row}\n`);
  console.log(row);
}

/** A camera of `id` that costs little: 156x116 pixels, `rate` pictures a second. */
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
  /** Nothing runs yet. `wrap`: a program with its arguments that starts the service; the service takes its place. */
  constructor(group, { cameras = [smallCamera(0)], environment = {}, wrap = [] } = {}) {
    this.folder = mkdtempSync(join(tmpdir(), 'ssl-visiond-faults.'));
    this.state = join(this.folder, 'state');
    this.settingsFile = join(this.folder, 'admin.json');
    this.environment = environment;
    this.wrap = wrap;
    // Without memory for the last seconds, which comes some seconds after the start: tests look whether memory grows.
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

  /** The process is there when this returns, no more. */
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

  /** Milliseconds until it was ready. */
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

  /** On a connection of its own: {status, json}; throws when there is no whole answer. */
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

  /** Names of files in the state folder, with those of its folders; each whole JSON, where it is JSON. */
  stateFiles(folder = this.state) {
    return readdirSync(folder, { recursive: true }).filter((name) => {
      if (name.endsWith('.json')) JSON.parse(readFileSync(join(folder, name), 'utf8'));
      return true;
    });
  }

  /** Collects the packets of detections: {camera, number, capture_s, sent_s, at_ms}. */
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
       * Frames that cameras' pipelines made and nobody got, from the first on that came: of one camera or of all. What
       * came and this process was too slow to take is not among them.
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
