// SPDX-License-Identifier: Apache-2.0
// The real service with its simulated cameras, for tests that use its port.
//   SSLV_DAEMON  the service; default: the release build
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, readlinkSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { isDeepStrictEqual } from 'node:util';
import { setTimeout as pause } from 'node:timers/promises';
import { fileURLToPath } from 'node:url';

export const root = fileURLToPath(new URL('../..', import.meta.url));
// The timeout of all waits. Reaching it means a hang: a busy machine or a sanitizer takes far less.
export const PATIENCE_MS = 300_000;
export const DAEMON = process.env.SSLV_DAEMON ?? join(root, 'build/release/bin/ssl-visiond');

/** Polls until `wanted` accepts the value, and returns it; on timeout fails with `tell` of the last value. */
export async function becomes(look, wanted, tell = JSON.stringify) {
  const deadline = Date.now() + PATIENCE_MS;
  for (;;) {
    const now = await look();
    if (wanted(now)) return now;
    if (Date.now() >= deadline) assert.fail(`it does not become ${wanted}: ${String(tell(now)).slice(0, 1500)}`);
    await pause(50);
  }
}

/** Retries until no assertion fails: for comparing two sources that update at different times. */
export async function eventually(check) {
  const deadline = Date.now() + PATIENCE_MS;
  for (;;) {
    try {
      return await check();
    } catch (error) {
      if (!(error instanceof assert.AssertionError) || Date.now() >= deadline) throw error;
    }
    await pause(50);
  }
}

/** Checks and alerts that depend only on the load of this computer. */
export const OF_THE_COMPUTER = { checks: ['pictures', 'latency', 'computer'], alerts: ['camera_slow', 'frames_dropped', 'latency_high', 'stage_slow'] };

/** The parts of a status that waits depend on. */
const tellStatus = ({ cameras, alerts, ...others }) => JSON.stringify({
  cameras: cameras.map(({ id, backend, state, error, frames, fps, robots, balls }) => ({ id, backend, state, error, frames, fps, robots, balls })),
  alerts: alerts.map(({ id }) => id), ...others,
});

export async function freeTcpPort() {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const { port } = server.address();
  server.close();
  await once(server, 'close');
  return port;
}

/**
 * A port for a multicast group, reserved while this process runs: the TCP port of the same number keeps other tests
 * away, and the UDP socket keeps away programs that take any port. Both allow sockets that share the port.
 */
export async function freeUdpPort() {
  for (;;) {
    const claim = createServer().listen(0, '127.0.0.1').unref();
    await once(claim, 'listening');
    const { port } = claim.address();
    const socket = createSocket({ type: 'udp4', reuseAddr: true }).unref().bind(port, '127.0.0.1');
    try {
      await once(socket, 'listening');
      return port;
    } catch {
      claim.close();
    }
  }
}

/** Datagrams to this port that the kernel dropped because this process did not read them in time. */
function unfetched(port) {
  const own = new Set();
  for (const fd of readdirSync('/proc/self/fd')) {
    try {
      own.add(/^socket:\[(\d+)\]$/.exec(readlinkSync(`/proc/self/fd/${fd}`))?.[1]);
    } catch {
      // closed meanwhile
    }
  }
  const rows = readFileSync('/proc/self/net/udp', 'latin1').split('\n').slice(1).map((row) => row.trim().split(/\s+/));
  const ours = rows.filter(([, local, , , , , , , , inode]) => own.has(inode) && parseInt(local?.split(':')[1], 16) === port);
  return ours.reduce((sum, row) => sum + Number(row.at(-1)), 0);
}

/** Receives a group until it is closed: `heard(packet)`. */
export async function listenTo(group, port, heard, address = '127.0.0.1') {
  const socket = createSocket({ type: 'udp4', reuseAddr: true, recvBufferSize: 4 << 20 }).bind(port);
  socket.on('message', heard);
  await once(socket, 'listening');
  socket.addMembership(group, address);
  let closed = null;
  return {
    /** Packets that were sent but that this process was too slow to receive. */
    missed: () => closed ?? unfetched(port),
    close() {
      if (closed !== null) return;
      closed = unfetched(port);
      socket.close();
    },
  };
}

/** Keeps a receive-only raw WebSocket open: the service closes one that does not answer its pings. */
export function answerPings(socket) {
  const PING = 0x89, PONG = 0x8a;
  socket.on('data', (bytes) => {
    if (bytes[0] === PING) socket.write(Buffer.from([PONG, 0x80 | bytes[1], 0, 0, 0, 0, ...bytes.subarray(2, 2 + bytes[1])])); // masked with zeros
  });
}

/**
 * Copies a built panel to `to` as another version: all scripts are renamed, also where they refer to each other; the
 * entry is `assets/index-upgraded.js`.
 */
export function upgradePanel(built, to) {
  cpSync(built, to, { recursive: true });
  const scripts = readdirSync(join(to, 'assets')).filter((name) => name.endsWith('.js'));
  const names = scripts.map((name) => [name, /^index-/.test(name) ? 'index-upgraded.js' : name.replace(/\.js$/, '-upgraded.js')]);
  for (const file of readdirSync(to, { recursive: true })) {
    if (file.endsWith('.gz')) rmSync(join(to, file));
    if (!/\.(html|js)$/.test(file)) continue;
    const text = names.reduce((now, [old, name]) => now.replaceAll(old, name), readFileSync(join(to, file), 'utf8'));
    writeFileSync(join(to, file), text.replace(/"[0-9a-f]{16}"/, '"0123456789abcdef"'));
  }
  for (const [old, name] of names) renameSync(join(to, 'assets', old), join(to, 'assets', name));
}

/** The demo with packets to `group`, not started yet. `settings` may be changed before the start. */
export async function createService(group) {
  const folder = mkdtempSync(join(tmpdir(), 'ssl-visiond-panel.'));
  const settingsFile = join(folder, 'admin.json');
  const stateFolder = join(folder, 'state');
  const settings = JSON.parse(readFileSync(join(root, 'config/demo.json'), 'utf8'));
  Object.assign(settings.network.vision, { group, interface: 'lo', port: await freeUdpPort() });
  // A higher rate would test nothing more and would slow down other tests.
  for (const { source } of settings.cameras) source.frame_rate_hz = 10;
  settings.network.referee = { enabled: false };
  settings.panel = { port: 0 };
  settings.recording = { last_seconds: { memory_mb: 64 } }; // many services run at once
  let daemon = null;
  let ended = null;
  let first = null;
  let log = [];
  /** {port}, or {code} if it exits at once. */
  const spawnDaemon = async () => {
    daemon = spawn(DAEMON, ['--config', settingsFile, '--panel', service.panelFolder, '--files', join(root, 'tests'), ...service.options], {
      env: { ...process.env, STATE_DIRECTORY: stateFolder },
      stdio: ['ignore', 'ignore', 'pipe'],
    });
    // On `close` rather than `exit`: by then all of its output has been read.
    ended = new Promise((resolve, reject) => { daemon.once('error', reject).once('close', (code) => resolve({ code })); });
    ended.catch(() => {});
    log = [];
    const ready = new Promise((resolve) => {
      createInterface(daemon.stderr).on('line', (line) => {
        log.push(line);
        const port = /panel on port (\d+)/.exec(line)?.[1];
        if (port) resolve({ port: Number(port) });
      });
    });
    return Promise.race([ready, ended]);
  };
  const isRunning = () => daemon !== null && daemon.exitCode === null && daemon.signalCode === null;

  const service = {
    folder,
    stateFolder,
    settings,
    /** The built panel that it serves. */
    panelFolder: join(root, 'webui/dist'),
    /** Further command line arguments. */
    options: [],
    /** Its log since the last start. */
    log: () => log.join('\n'),
    /** The log has its own pipe, so a line may arrive after the answer to its request. */
    logBecomes: (wanted) => becomes(service.log, (text) => wanted.test(text), String),
    /** Once a password is set, the panel moves to an address that others can reach; for a moment nothing listens on
     * its port. */
    opensToOthers: () => service.logBecomes(/panel on 0\.0\.0\.0 port/),
    pid: () => daemon.pid,
    address: (path) => `http://127.0.0.1:${settings.panel.port}/${path}`,

    /** Returns when it answers on `settings.panel.port`. */
    async start() {
      mkdirSync(stateFolder, { recursive: true });
      writeFileSync(settingsFile, JSON.stringify(settings));
      // EX_TEMPFAIL: while it was stopped, the kernel gave its port to a connection.
      const { port } = await becomes(spawnDaemon, ({ code }) => code !== 75, () => log.join('\n'));
      assert.ok(port, `${DAEMON} ended at once:\n${log.join('\n')}`);
      settings.panel.port = port;
    },

    async stop() {
      if (!isRunning()) return;
      daemon.kill('SIGTERM');
      const { code } = await ended;
      assert.equal(code, 0, `the service ends cleanly:\n${log.slice(-20).join('\n')}`);
    },

    /** Deletes its state folder; it must not be running. */
    async forget() {
      assert.ok(!isRunning());
      rmSync(stateFolder, { recursive: true, force: true });
    },

    async end() {
      await service.stop();
      rmSync(folder, { recursive: true, force: true });
    },

    async patch(...operations) {
      const answer = await fetch(service.address('api/settings'), { method: 'PATCH', body: JSON.stringify(operations) });
      assert.equal(answer.status, 200, await answer.text());
    },

    /** Polls the service's status until `wanted` accepts it. */
    statusBecomes: (wanted) => becomes(async () => (await fetch(service.address('api/status'))).json(), wanted, tellStatus),

    /**
     * For before each test: stores the settings on the first call and restores them later, even after a failed test.
     * Returns when the service and all cameras run.
     */
    async restore() {
      if (!isRunning()) await service.start();
      const { settings: now } = await (await fetch(service.address('api/settings'))).json();
      first ??= now;
      // Keep the current port: port 0 was only for the start, and the panel would move.
      const wanted = { ...first, panel: { ...first.panel, port: now.panel.port } };
      if (!isDeepStrictEqual(now, wanted)) await service.patch({ op: 'replace', path: '', value: wanted });
      await service.statusBecomes(({ cameras }) => cameras.length === first.cameras.length && cameras.every(({ state }) => state === 'running'));
    },
  };
  return service;
}
