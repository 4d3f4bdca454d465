// SPDX-License-Identifier: Apache-2.0
// What strangers on the team network can do: each attack of attacks.mjs for a while, then all at once, over loopback only,
// against the real service with two simulated cameras, a GigE camera and a match that is recorded. Beside it runs a service
// of the same cameras that no stranger knows of. Prints a table in Markdown; exit code 1 unless the service's packets are
// those of the other one, its tracks too, its memory grows by no more than MOST_GROWTH_MB, nothing is deleted, and no alert
// comes twice.
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
import { compare } from './compare.mjs';
import { Random } from './random.mjs';

const { values: options } = parseArgs({
  options: {
    minutes: { type: 'string', default: '10' }, seed: { type: 'string', default: '1' }, only: { type: 'string', multiple: true },
    rate: { type: 'string', default: '20' },
  },
});
const SECONDS = 60 * Number(options.minutes), SEED = Number(options.seed), RATE_HZ = Number(options.rate);
const MOST_GROWTH_MB = 64, MOST_OFF_MM = 1, QUIET_S = 10;
const FAKE_CAMERA = process.env.SSLV_FAKE_CAMERA ?? join(root, 'build/release/bin/fake_gige_camera');
const CAMERA_ADDRESS = '127.0.0.1';
const PASSWORDS = { admin: 'correct horse', viewer: 'battery staple' };
const STOP = 1, START = 2;

const attacks = ATTACKS.filter(({ name }) => !options.only || options.only.some((wanted) => name.includes(wanted)));
if (attacks.length === 0) throw new Error(`--only: there is ${ATTACKS.map(({ name }) => `"${name}"`).join(', ')}`);

// ---- two services and a match

const [attacked, control] = await Promise.all(['239.255.77.131', '239.255.77.132'].map((group) => createService(group)));
const groups = { attacked: ['239.255.77.133', '239.255.77.134'], control: ['239.255.77.135', '239.255.77.136'] };
for (const [who, service] of Object.entries({ attacked, control })) {
  const [tracker, referee] = groups[who];
  const { settings } = service;
  settings.network.tracker = { enabled: true, group: tracker, port: await freeUdpPort() };
  settings.network.referee = { enabled: true, group: referee, port: await freeUdpPort(), interface: 'lo' };
  settings.recording = { quota_mb: 100, keep_free_mb: 0, last_seconds: { memory_mb: 32 } };
  for (const { source } of settings.cameras) Object.assign(source, { frame_rate_hz: RATE_HZ, noise_sigma: 0 });
}
const [seen] = attacked.settings.cameras;
// Robots that no other camera sees, which stand still: what it shows stays the same.
const served = {
  source: { ...seen.source, pixel_format: 'bayer_rg8', frame_rate_hz: 10, speed: 0, robots_yellow: 2, robots_blue: 2, first_yellow_id: 12, first_blue_id: 12, balls: 0 },
  calibration: seen.calibration, heartbeat_s: 300,
};
attacked.settings.cameras.push({ ...seen, id: 2, name: 'GigE', source: { backend: 'aravis', camera: CAMERA_ADDRESS, silence_s: 300 } });

const said = { yellow: ['TIGERs Mannheim'], blue: ['ER-Force'], matchType: 1, stage: 0, command: 0 };
const gameControl = createSocket('udp4').bind(0, '127.0.0.1');
await once(gameControl, 'listening');
gameControl.setMulticastInterface('127.0.0.1');
const talking = setInterval(() => {
  for (const { settings: { network: { referee } } } of [attacked, control]) gameControl.send(gameController(said), referee.port, referee.group);
}, 250);

// ---- what is asked of the attacked one

const outside = Object.values(networkInterfaces()).flat().find(({ family, internal }) => family === 'IPv4' && !internal)?.address ?? '127.0.0.1';
if (outside === '127.0.0.1') console.log('This computer has no address but its loopback: HTTP comes from there, which is trusted more.\n');
const cookies = {};

function ask(method, path, { body, cookie, outside: isOutside = false } = {}) {
  const bytes = body === undefined || Buffer.isBuffer(body) || typeof body === 'string' ? body : JSON.stringify(body);
  const host = isOutside ? outside : '127.0.0.1';
  return new Promise((resolve) => {
    const sent = request({
      host, localAddress: host, port: attacked.settings.panel.port, path: `/${path}`, method, agent: false,
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
    sent.on('error', () => resolve({ status: 0, headers: {}, text: '', json: null }));
    sent.end(bytes);
  });
}
ask.cookies = async () => cookies;
const signIn = async (role) => (await becomes(() => ask('POST', 'api/session', { body: { password: PASSWORDS[role] } }), ({ status }) => status === 200, ({ text }) => text)).headers['set-cookie'][0].split(';')[0];
const asAdmin = (method, path, body) => ask(method, path, { body, cookie: cookies.admin });
const status = async () => (await asAdmin('GET', 'api/status')).json;
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

// ---- what is looked at

const memoryMb = () => Number(/^VmRSS:\s+(\d+)/m.exec(readFileSync(`/proc/${attacked.pid()}/status`, 'utf8'))[1]) / 1024;
const isAlive = () => { try { return process.kill(attacked.pid(), 0); } catch { return false; } };
const brightness = async () => (await asAdmin('GET', 'api/cameras/2/snapshot.jpg?width=64')).text.length;

/** Looks once a second until it is told to stop; returns what was wrong. */
function watch(kept, first) {
  let ends = false, most_mb = 0;
  const wrong = new Set(), alerts = new Set();
  const pid = attacked.pid();
  const done = (async () => {
    while (!ends) {
      if (!isAlive()) return void wrong.add('the service has ended');
      most_mb = Math.max(most_mb, memoryMb());
      const now = await status();
      const counts = new Map();
      for (const { id, camera, title } of now?.alerts ?? []) {
        alerts.add(id);
        const kind = `${id} ${camera ?? ''}`;
        counts.set(kind, [...(counts.get(kind) ?? []), title]);
      }
      for (const [kind, titles] of counts) if (titles.length > 1) wrong.add(`${titles.length} alerts of a kind: ${kind}: ${titles.slice(0, 3).join('; ')}`);
      for (const camera of now?.cameras ?? []) if (camera.state !== 'running') wrong.add(`camera ${camera.id} is ${camera.state}`);
      const there = new Set(readdirSync(recordingsFolder));
      for (const name of kept) if (!there.has(name)) wrong.add(`${name} was deleted`);
      if ((await ask('GET', 'healthz', { outside: true })).status !== 200) wrong.add('/healthz does not answer');
      await pause(1000);
    }
  })();
  return async () => {
    ends = true;
    await done;
    const snapshot = await brightness();
    if (isAlive() && Math.abs(snapshot - first.snapshot) > 0.2 * first.snapshot) wrong.add(`the GigE camera's image has ${snapshot} bytes, before ${first.snapshot}`);
    if (attacked.pid() !== pid) wrong.add('the service was started again');
    return { wrong, alerts, most_mb };
  };
}

let failed = false;
const rows = [];
function tell(name, seconds, figures, { wrong, alerts, most_mb }, first) {
  const growth_mb = most_mb - first.memory_mb;
  const share = figures.compared / Math.max(1, figures.frames.control);
  if (figures.compared === 0) wrong.add('no own packet could be compared');
  if (figures.different > 0) wrong.add(`${figures.different} own packets differ`);
  if (figures.notFinite > 0) wrong.add(`${figures.notFinite} packets of tracks have no numbers`);
  if (!(figures.max_mm <= MOST_OFF_MM)) wrong.add(`tracks are off by ${figures.max_mm.toFixed(2)} mm`);
  if (figures.lost > 0) wrong.add(`${figures.lost} times a track was missing`);
  if (growth_mb > MOST_GROWTH_MB) wrong.add(`memory grew by ${growth_mb.toFixed(0)} MB`);
  failed ||= wrong.size > 0;
  const row = `| ${name} | ${seconds.toFixed(0)} | ${figures.compared} (${(100 * share).toFixed(1)} %) | ${figures.different} | ${figures.p99_mm.toFixed(2)} | ${figures.max_mm.toFixed(2)} | ${growth_mb.toFixed(0)} | ${[...alerts].join(', ') || '-'} | ${[...wrong].join('; ') || 'none'} |`;
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
  // A stranger is whoever knows no password: there is one.
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

  const comparison = await compare(attacked, control);
  await pause(20_000); // until cameras have been brought together and memory is what it becomes
  const kept = readdirSync(recordingsFolder).filter((name) => /\.(log|log\.gz|clip)$/.test(name));
  const first = { memory_mb: memoryMb(), snapshot: await brightness() };
  console.log(`Two simulated cameras at ${RATE_HZ} Hz and a GigE camera, a match, ${kept.length} recordings, ${first.memory_mb.toFixed(0)} MB; seed ${SEED}\n`);
  console.log('| attack | s | own packets compared | different | tracks off, p99 (mm) | max (mm) | memory + (MB) | alerts | wrong |\n|---|---:|---:|---:|---:|---:|---:|---|---|');

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
