// SPDX-License-Identifier: Apache-2.0
// The service is killed, or the power fails, while a match log is being written: all data on the disk remains, and the
// file can always be read. Only ./run faults, on an otherwise idle machine, checks that at most one second is missing.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { closeSync, copyFileSync, existsSync, mkdirSync, openSync, readdirSync, readFileSync, rmSync, writeFileSync, writeSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { after, describe, it } from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { gunzipSync } from 'node:zlib';
import { cannotUnshare, FaultyService, IS_TIMED, report, smallCamera, tries } from './faults.mjs';
import { becomes, DAEMON } from './service.mjs';

const CTL = process.env.SSLV_CTL ?? join(dirname(DAEMON), 'ssl-visionctl');
const LOGGED_DISK = join(dirname(DAEMON), 'logged_disk');
const MOST_LOST_S = 1;

const services = [];
async function create() {
  const service = new FaultyService(`239.255.78.${101 + services.length}`, { cameras: [smallCamera(0, 60), smallCamera(1, 60)] });
  services.push(service);
  await service.prepare();
  return service;
}
after(() => Promise.all(services.map((service) => service.remove())));

/** The times (Unix, s) of all messages in a packed log, read from the format's description; fails if it is damaged. */
function timesIn(file) {
  const bytes = gunzipSync(readFileSync(file));
  assert.equal(bytes.toString('latin1', 0, 12), 'SSL_LOG_FILE');
  const times = [];
  for (let at = 16; at < bytes.length; at += 16 + bytes.readInt32BE(at + 12)) times.push(Number(bytes.readBigInt64BE(at)) * 1e-9);
  return times;
}

/** Messages that a log must certainly contain at a time (Unix, s), derived from what the service reports while
 * recording. */
class Written {
  sure = [];
  #bytes = 0;
  #seen = null; // messages received so far, and the number of writes since

  look({ bytes, messages }) {
    const count = Object.values(messages).reduce((sum, one) => sum + one);
    if (bytes > this.#bytes && this.#seen) this.#seen.writes++;
    this.#bytes = bytes;
    // The first write may have begun before they were received.
    if (this.#seen?.writes === 2) {
      this.sure.push({ at_s: Date.now() / 1000, count: this.#seen.count });
      this.#seen = null;
    }
    this.#seen ??= { count, writes: 0 };
  }
  before = (at_s) => this.sure.findLast((one) => one.at_s <= at_s)?.count ?? 0;
}

/** Checks that everything written is there and, in timed runs, that at most a second is missing. */
function missingOf(times, written, end_s) {
  assert.ok(times.length >= written.before(end_s), `${times.length} messages, but ${written.before(end_s)} were written`);
  const missing_s = end_s - times.at(-1);
  if (IS_TIMED) assert.ok(missing_s <= MOST_LOST_S, `${missing_s} s are missing`);
  return missing_s;
}

const logs = (service) => service.get('api/recordings').then(({ logs: all }) => all);
const state = async (service) => (await service.get('api/recordings')).match_log;
async function record(service, name) {
  await service.good('POST', 'api/recordings/match-log', { record: true, name });
  return (await becomes(() => state(service), ({ state: now, messages }) => now === 'recording' && messages.vision > 20)).name;
}

describe('a match log while the service is killed', () => {
  it('keeps what was written, and is repaired at the next start', async () => {
    const service = await create();
    const rounds = tries(4, 200), lost_ms = [];
    await service.start();
    for (let round = 0; round < rounds; ++round) {
      const name = await record(service, `killed_${round}`);
      const written = new Written();
      await becomes(async () => written.look(await state(service)), () => written.sure.length > 0);
      await pause(Math.random() * 1200);
      const killed_s = Date.now() / 1000;
      await service.kill('SIGKILL');
      await service.start();
      const log = await becomes(() => logs(service).then((all) => all.find((one) => one.name === name)), (one) => one && one.seconds !== null);
      assert.equal(log.problem, '');
      const file = join(service.state, 'recordings', name);
      assert.ok(!existsSync(`${file}.unfinished`) && existsSync(`${file}.index`), 'it has an index again');
      lost_ms.push(missingOf(timesIn(file), written, killed_s) * 1000);
      await service.good('DELETE', `api/recordings/logs/${name}`);
    }
    await service.stop();
    report('a match log while the service is killed (times: what is missing at its end)', rounds, 0, lost_ms);
  });
});

/** The requests that a disk received: [{ kind, time_s, place, bytes }]. */
function disksLog(file) {
  const all = readFileSync(file), records = [];
  const HEAD = 21;
  for (let at = 0; at + HEAD <= all.length;) {
    const count = all.readUInt32LE(at + 17);
    records.push({ kind: String.fromCharCode(all[at]), time_s: all.readDoubleLE(at + 1), place: Number(all.readBigUInt64LE(at + 9)), bytes: all.subarray(at + HEAD, at + HEAD + count) });
    at += HEAD + count;
  }
  return records;
}

const DISK_BYTES = 64 * 1024 * 1024, SECTOR = 4096;

function cannotCutPower() {
  if (cannotUnshare()) return cannotUnshare();
  if (!existsSync(LOGGED_DISK)) return `no ${LOGGED_DISK}: libfuse3-dev was not there when it was built`;
  return ['/dev/fuse', '/dev/loop-control'].every(existsSync) ? false : 'needs /dev/fuse and loop devices';
}

/** Attaches a file as a disk and mounts it; returns a function that detaches it. */
function mountImage(image, folder) {
  mkdirSync(folder, { recursive: true });
  const device = execFileSync('losetup', ['--find', '--show', image], { encoding: 'utf8' }).trim();
  try {
    execFileSync('mount', [device, folder]);
  } catch (error) {
    execFileSync('losetup', ['--detach', device]);
    throw error;
  }
  return () => {
    execFileSync('umount', [folder]);
    execFileSync('losetup', ['--detach', device]);
  };
}

describe('a match log while the power fails', () => {
  // A real file system (ext4) on a disk that logs its requests. After a power cut the disk has all writes before the
  // last flush, and any subset of the later ones.
  it('keeps what was written, and is repaired', { skip: cannotCutPower() }, async () => {
    const service = await create();
    const cuts = tries(12, 200), recorded_s = 10 + cuts / 4;
    const disk = join(service.folder, 'disk'), diskLog = join(service.folder, 'disk.log');
    mkdirSync(disk);
    const server = spawn(LOGGED_DISK, [disk, `${DISK_BYTES}`, diskLog], { stdio: 'inherit' });
    const written = new Written();
    let name, began_s, ended_s;
    try {
      await becomes(() => existsSync(join(disk, 'disk')), (is) => is);
      execFileSync('mkfs.ext4', ['-q', join(disk, 'disk')], { stdio: 'pipe' });
      const unmount = mountImage(join(disk, 'disk'), service.state);
      try {
        service.settings.recording.keep_free_mb = 1;
        service.writeSettings();
        await service.start();
        name = await record(service, 'power');
        began_s = Date.now() / 1000;
        const look = async () => written.look(await state(service));
        await becomes(look, () => written.sure.length > 3 && Date.now() / 1000 > began_s + recorded_s);
        ended_s = Date.now() / 1000;
        await service.kill('SIGKILL');
      } finally {
        await service.kill('SIGKILL');
        unmount();
      }
    } finally {
      execFileSync('umount', [disk]);
      server.kill();
    }

    const records = disksLog(diskLog);
    // The part that is certainly on the disk grows with the time of the cut.
    const sure = join(service.folder, 'sure.img'), image = join(service.folder, 'cut.img'), folder = join(service.folder, 'cut');
    writeFileSync(sure, '');
    execFileSync('truncate', ['--size', `${DISK_BYTES}`, sure]);
    const times_s = Array.from({ length: cuts }, () => began_s + 2 + Math.random() * (ended_s - began_s - 2)).sort((a, b) => a - b);
    const lost_ms = [];
    let at = 0; // records before this index are on the disk
    for (const cut_s of times_s) {
      const end = records.findIndex(({ time_s }) => time_s > cut_s);
      const flushed = records.slice(0, end).findLastIndex(({ kind }) => kind === 'F');
      const whole = openSync(sure, 'r+');
      for (; at < flushed; ++at) if (records[at].kind === 'W') writeSync(whole, records[at].bytes, 0, records[at].bytes.length, records[at].place);
      closeSync(whole);
      execFileSync('cp', ['--sparse=always', sure, image]);
      const cut = openSync(image, 'r+');
      for (const { kind, place, bytes } of records.slice(at, end)) {
        for (let i = 0; kind === 'W' && i < bytes.length; i += SECTOR)
          if (Math.random() < 0.5) writeSync(cut, bytes, i, Math.min(SECTOR, bytes.length - i), place + i);
      }
      closeSync(cut);
      const unmount = mountImage(image, folder);
      try {
        const there = join(service.folder, 'after_cut.log.gz');
        copyFileSync(join(folder, 'recordings', name), there);
        execFileSync(CTL, ['match-log', 'repair', there], { stdio: 'pipe' });
        rmSync(`${there}.damaged`, { force: true });
        lost_ms.push(missingOf(timesIn(there), written, cut_s) * 1000);
      } finally {
        unmount();
      }
    }
    // The service does the same repair when it starts on such a disk.
    const unmount = mountImage(image, service.state);
    try {
      await service.start();
      const log = await becomes(() => logs(service).then((all) => all.find((one) => one.name === name)), (one) => one && one.seconds !== null);
      assert.equal(log.problem, '');
      assert.ok(!readdirSync(join(service.state, 'recordings')).some((file) => file.endsWith('.unfinished')));
      await service.stop();
    } finally {
      await service.kill('SIGKILL');
      unmount();
    }
    report('a match log while the power fails (times: what is missing at its end)', cuts, 0, lost_ms);
  });
});
