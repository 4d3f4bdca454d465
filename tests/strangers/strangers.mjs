// SPDX-License-Identifier: Apache-2.0
// Attacks by strangers on the team network: runs each attack of attacks.mjs for a while, then all at once, over
// loopback only, against the real service with two simulated cameras, a GigE camera and a match that is recorded. A
// second service with the same simulated cameras is not attacked. Prints a table in Markdown. Exit code 1 unless both
// services' packets and tracks are equal (bounds: compare.mjs), peak memory grows by at most MOST_GROWTH_MB, the
// service answers, its cameras run, nothing is deleted, and no alert occurs twice. Exit code 77: not possible here.
//   node strangers.mjs [--minutes 10] [--seed 1] [--only NAME ...] [--rate 20]
//   SSLV_DAEMON, SSLV_FAKE_CAMERA: the programs; default: the release build's
import { spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { request } from 'node:http';
import { networkInterfaces } from 'node:os';
import { join } from 'node:path';
import { setTimeout as pause } from 'node:timers/promises';
import { parseArgs } from 'node:util';
import { gameController } from '../e2e/league_messages.mjs';
import { becomes, createService, freeUdpPort, root } from '../e2e/service.mjs';
import { ATTACKS } from './attacks.mjs';
import { compare, faultsOf } from './compare.mjs';
import { Random } from './random.mjs';

const { values: options } = parseArgs({
  options: {
    minutes: { type: 'string', default: '10' }, seed: { type: 'string', default: '1' }, only: { type: 'string', multiple: true },
    rate: { type: 'string', default: '20' },
  },
});
const SECONDS = 60 * Number(options.minutes), SEED = Number(options.seed), RATE_HZ = Number(options.rate);
const MOST_GROWTH_MB = 64, MOST_IMAGE_CHANGE = 0.2, QUIET_S = 10, ANSWER_MS = 60_000;
const FAKE_CAMERA = process.env.SSLV_FAKE_CAMERA ?? join(root, 'build/release/bin/fake_gige_camera');
const CAMERA_ADDRESS = '127.0.0.1';
const PASSWORDS = { admin: 'correct horse', viewer: 'battery staple' };
const STOP = 1, START = 2;

const attacks = ATTACKS.filter(({ name }) => !options.only || options.only.some((wanted) => name.includes(wanted)));
if (attacks.length === 0) throw new Error(`--only: there is ${ATTACKS.map(({ name }) => `"${name}"`).join(', ')}`);

// An address outside the field's subnet, which is the loopback's. HTTP attacks also use it: loopback is trusted more.
const outside = Object.values(networkInterfaces()).flat().find(({ family, internal }) => family === 'IPv4' && !internal)?.address;
if (!outside) {
  console.error('strangers: this computer has no address but its loopback, so no stranger can come from another subnet');
  process.exit(77);
}

// ---- two services and a match

const [attacked, control] = await Promise.all(['239.255.77.131', '239.255.77.132'].map((group) => createService(group)));
const groups = { attacked: ['239.255.77.133', '239.255.77.134'], control: ['239.255.77.135', '239.255.77.136'] };
for (const [who, service] of Object.entries({ attacked, control })) {
  const [tracker, referee] = groups[who];
  const { settings } = service;
  settings.network.tracker = { enabled: true, group: tracker, port: await freeUdpPort() };
  settings.network.referee = { enabled: true, group: referee, port: await freeUdpPort(), interface: 'lo' };
  settings.recording = { quota_mb: 100, keep_free_mb: 0, last_seconds: { memory_mb: 32 } };
  // A static scene: the order of the cameras' images has no effect on the tracks, so any difference is an effect of
  // strangers.
  for (const { source } of settings.cameras) Object.assign(source, { frame_rate_hz: RATE_HZ, noise_sigma: 0, speed: 0 });
}
const [seen] = attacked.settings.cameras;
// Standing robots that no other camera sees, so this camera's image never changes.
const served = {
  source: { ...seen.source, pixel_format: 'bayer_rg8', frame_rate_hz: 10, speed: 0, robots_yellow: 2, robots_blue: 2, first_yellow_id: 12, first_blue_id: 12, balls: 0 },
  calibration: seen.calibration, heartbeat_s: 300,
};
const alone = ['yellow', 'blue'].flatMap((team) => Array.from({ length: served.source[`robots_${team}`] }, (_, i) => `${team} ${served.source[`first_${team}_id`] + i}`));
attacked.settings.cameras.push({ ...seen, id: 2, name: 'GigE', source: { backend: 'aravis', camera: CAMERA_ADDRESS, silence_s: 300 } });

const said = { yellow: ['TIGERs Mannheim'], blue: ['ER-Force'], matchType: 1, stage: 0, command: 0 };
const gameControl = createSocket('udp4').bind(0, '127.0.0.1');
await once(gameControl, 'listening');
gameControl.setMulticastInterface('127.0.0.1');
const talking = setInterval(() => {
  for (const { settings: { network: { referee } } } of [attacked, control]) gameControl.send(gameController(said), referee.port, referee.group);
}, 250);

// ---- requests to the attacked service

const cookies = {};

/** Status 0: no answer. */
function ask(method, path, { body, cookie, outside: isOutside = false } = {}) {
  const bytes = body === undefined || Buffer.isBuffer(body) || typeof body === 'string' ? body : JSON.stringify(body);
  const host = isOutside ? outside : '127.0.0.1';
  return new Promise((resolve) => {
    const sent = request({
      host, localAddress: host, port: attacked.settings.panel.port, path: `/${path}`, method, agent: false, signal: AbortSignal.timeout(ANSWER_MS),
      headers: { ...(cookie ? { Cookie: cookie } : {}), ...(bytes === undefined ? {} : { 'Content-Length': Buffer.byteLength(bytes) }) },
    }, (answer) => {
      const parts = [];
      answer.on('data', (part) => parts.push(part)).on('error', () => {});
      answer.on('close', () => {
        const text = Buffer.concat(parts).toString();
        let json = null;
        try { json = JSON.parse(text); } catch { /* no JSON */ }
        resolve({ status: answer.statusCode, headers: answer.headers, text, json });
      });
    });
    sent.on('error', ({ message }) => resolve({ status: 0, headers: {}, text: message, json: null }));
    sent.end(bytes);
  });
}
ask.cookies = async () => cookies;
const signIn = async (role) => (await becomes(() => ask('POST', 'api/session', { body: { password: PASSWORDS[role] } }), ({ status }) => status === 200, ({ text }) => text)).headers['set-cookie'][0].split(';')[0];
const asAdmin = (method, path, body) => ask(method, path, { body, cookie: cookies.admin });
/** The service's status; null if there is none. */
const status = async () => {
  const { status: code, json } = await asAdmin('GET', 'api/status');
  return code === 200 ? json : null;
};
const recordingsFolder = join(attacked.stateFolder, 'recordings');
const isRecording = () => becomes(async () => (await asAdmin('GET', 'api/recordings')).json?.match_log, (log) => log?.state === 'recording');

async function socketAt(address) {
  const socket = createSocket({ type: 'udp4', sendBufferSize: 1 << 20 }).bind(0, address);
  await once(socket, 'listening');
  socket.setMulticastInterface('127.0.0.1');
  socket.on('error', () => {});
  opened.push(socket);
  return { socket, send: (bytes, port, host) => socket.send(bytes, port, host, () => {}) };
}
const opened = [];

// ---- what is monitored

/** `what`: VmRSS is the current memory, VmHWM the peak since the start or the last forgetMost(). */
const memoryMb = (what) => Number(new RegExp(`^${what}:\\s+(\\d+)`, 'm').exec(readFileSync(`/proc/${attacked.pid()}/status`, 'utf8'))[1]) / 1024;
const forgetMost = () => writeFileSync(`/proc/${attacked.pid()}/clear_refs`, '5');
const isAlive = () => { try { return process.kill(attacked.pid(), 0); } catch { return false; } };
/** Size of the GigE camera's image; 0 if there is none. */
const imageBytes = async () => {
  const { status: code, text } = await asAdmin('GET', 'api/cameras/2/snapshot.jpg?width=64');
  return code === 200 ? text.length : 0;
};

/** Checks once a second until the returned function is called, then once more; that function returns the faults. */
function watch(kept, first) {
  let ends = false, oddImage = null;
  const wrong = new Set(), alerts = new Set();
  const frames = new Map(); // by camera: at the first and at the newest check
  const pid = attacked.pid();
  forgetMost();
  const look = async () => {
    const now = await status();
    if (!now) wrong.add('/api/status does not answer');
    const counts = new Map();
    for (const { id, camera, title } of now?.alerts ?? []) {
      alerts.add(id);
      const kind = `${id} ${camera ?? ''}`;
      counts.set(kind, [...(counts.get(kind) ?? []), title]);
    }
    for (const [kind, titles] of counts) if (titles.length > 1) wrong.add(`${titles.length} alerts of a kind: ${kind}: ${titles.slice(0, 3).join('; ')}`);
    for (const { id, state, frames: newest } of now?.cameras ?? []) {
      if (state !== 'running') wrong.add(`camera ${id} is ${state}`);
      frames.set(id, { first: frames.get(id)?.first ?? newest, newest });
    }
    const there = new Set(readdirSync(recordingsFolder));
    for (const name of kept) if (!there.has(name)) wrong.add(`${name} was deleted`);
    const { status: health, text } = await ask('GET', 'healthz'); // strangers may use up their address' connections
    if (health !== 200) wrong.add(`/healthz does not answer: ${text}`);
    const bytes = await imageBytes();
    if (Math.abs(bytes - first.image_bytes) > MOST_IMAGE_CHANGE * first.image_bytes) oddImage ??= bytes;
  };
  const done = (async () => {
    while (!ends && isAlive()) {
      await look();
      await pause(1000);
    }
  })();
  return async () => {
    ends = true;
    await done;
    const isThere = isAlive();
    if (isThere) await look();
    else wrong.add('the service has ended');
    if (oddImage !== null) wrong.add(`the GigE camera's image had ${oddImage} bytes, before ${first.image_bytes}`);
    for (const { id } of attacked.settings.cameras) if (!(frames.get(id)?.newest > frames.get(id)?.first)) wrong.add(`camera ${id} took no image`);
    if (attacked.pid() !== pid) wrong.add('the service was started again');
    return { wrong, alerts, most_mb: isThere ? memoryMb('VmHWM') : NaN };
  };
}

let failed = false;
const rows = [];
function tell(name, seconds, figures, { wrong, alerts, most_mb }, first) {
  const growth_mb = most_mb - first.memory_mb;
  for (const fault of faultsOf(figures)) wrong.add(fault);
  if (!(growth_mb <= MOST_GROWTH_MB)) wrong.add(`memory grew by ${growth_mb.toFixed(0)} MB`);
  failed ||= wrong.size > 0;
  const { compared, share, tracksShare, different, p99_mm, max_mm, silent_ms } = figures;
  const row = `| ${name} | ${seconds.toFixed(0)} | ${compared} (${(100 * share).toFixed(1)} %) | ${different} | ${(100 * tracksShare).toFixed(1)} % | ${p99_mm.toFixed(2)} | ${max_mm.toFixed(2)} | ${silent_ms.toFixed(0)} | ${growth_mb.toFixed(0)} | ${[...alerts].join(', ') || '-'} | ${[...wrong].join('; ') || 'none'} |`;
  rows.push(row);
  console.log(row);
}

// ---- the run

const servedFile = join(attacked.folder, 'served.json');
writeFileSync(servedFile, JSON.stringify(served));
const camera = spawn(FAKE_CAMERA, [CAMERA_ADDRESS, 'STRANGE01', servedFile], { stdio: ['ignore', 'pipe', 'inherit'] });
let watcher = null;
try {
  await once(camera.stdout, 'data');
  await Promise.all([attacked.start(), control.start()]);
  // A stranger is a client without the password, so one must be set.
  const set = await ask('PUT', 'api/passwords/admin', { body: { password: PASSWORDS.admin } });
  if (set.status !== 200) throw new Error(set.text);
  await attacked.opensToOthers();
  cookies.admin = await signIn('admin');
  await asAdmin('PUT', 'api/passwords/viewer', { password: PASSWORDS.viewer, admin_password: PASSWORDS.admin });

  await becomes(status, (now) => now?.cameras.length === 3 && now.cameras.every(({ frames }) => frames > 20), (now) => JSON.stringify(now?.cameras));
  await control.statusBecomes(({ cameras }) => cameras.every(({ frames }) => frames > 20));
  // Older logs, one of them pinned, and a clip.
  for (const name of ['first', 'second', 'third']) {
    await asAdmin('POST', 'api/recordings/match-log', { record: true, name });
    await isRecording();
    await pause(2000);
    await asAdmin('POST', 'api/recordings/match-log', { record: false });
  }
  const { logs } = (await asAdmin('GET', 'api/recordings')).json;
  await asAdmin('PATCH', `api/recordings/logs/${logs[0].name}`, { pinned: true });
  await asAdmin('POST', 'api/recordings/clips', { name: 'before' });
  Object.assign(said, { stage: 1, command: STOP });
  await isRecording();
  Object.assign(said, { command: START });
  await becomes(async () => readdirSync(recordingsFolder).filter((name) => name.endsWith('.clip')).length, (count) => count > 0);

  const comparison = await compare(attacked, control, alone);
  forgetMost();
  await pause(20_000); // until the cameras' clocks are aligned and the memory has settled
  const kept = readdirSync(recordingsFolder).filter((name) => /\.(log|log\.gz|clip)$/.test(name));
  const first = { memory_mb: memoryMb('VmHWM'), image_bytes: await becomes(imageBytes, (bytes) => bytes > 0) };
  console.log(`Two simulated cameras at ${RATE_HZ} Hz and a GigE camera, a match, ${kept.length} recordings, ${first.memory_mb.toFixed(0)} MB; seed ${SEED}\n`);
  console.log('| attack | s | own packets compared | different | tracks compared | off, p99 (mm) | max (mm) | silent (ms) | memory + (MB) | alerts | wrong |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---|---|');

  const during = async (name, seconds, some) => {
    const ends = Date.now() + seconds * 1000;
    const complaints = new Set();
    const context = (attack) => ({
      random: new Random(SEED, attack.name), socketAt, ask, signIn, passwords: PASSWORDS, pause,
      isOver: () => Date.now() >= ends || !isAlive(),
      check: (holds, what) => { if (!holds) complaints.add(what); },
      ownFrames: comparison.listen, pid: attacked.pid, recordings: recordingsFolder,
      vision: attacked.settings.network.vision, tracker: attacked.settings.network.tracker, referee: attacked.settings.network.referee,
      panel: { port: attacked.settings.panel.port, outside }, gige: { address: CAMERA_ADDRESS },
    });
    watcher = watch(kept, first);
    comparison.begin();
    const work = some.map(async (attack) => {
      try {
        await attack.run(context(attack));
      } catch (error) {
        if (isAlive()) complaints.add(`the attack "${attack.name}" failed: ${error.message}`);
      }
    });
    while (Date.now() < ends && isAlive()) await pause(100);
    await Promise.all(work);
    const figures = comparison.end();
    const seen_ = await watcher();
    watcher = null;
    for (const complaint of complaints) seen_.wrong.add(complaint);
    for (const socket of opened.splice(0)) socket.close();
    tell(name, seconds, figures, seen_, first);
    if (!isAlive()) throw new Error(`the service has ended:\n${attacked.log().split('\n').slice(-20).join('\n')}`);
  };
  await during('(none)', QUIET_S, []);
  const slice_s = SECONDS / (attacks.length + (attacks.length > 1 ? 3 : 0));
  for (const attack of attacks) await during(attack.name, slice_s, [attack]);
  if (attacks.length > 1) await during('all at once', 3 * slice_s, attacks);
  await during('(none)', QUIET_S, []);
  comparison.close();
} catch (error) {
  failed = true;
  console.error(error);
} finally {
  await watcher?.();
  clearInterval(talking);
  gameControl.close();
  for (const service of [attacked, control]) await service.end().catch((error) => { failed = true; console.error(error.message); });
  camera.kill();
}
process.exitCode = failed ? 1 : 0;
