// SPDX-License-Identifier: Apache-2.0
// The service keeps running: with failing cameras beside good ones, ports in use, clock changes, networks that vanish
// and return, signals at any moment.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { randomBytes } from 'node:crypto';
import { once } from 'node:events';
import { copyFileSync, existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { join } from 'node:path';
import { after, describe, it } from 'node:test';
import { fileURLToPath } from 'node:url';
import { openViewer } from '../figures/viewer.mjs';
import { cannotUnshare, CLOCK, FaultyService, IS_TIMED, preload, report, smallCamera, tries } from './faults.mjs';
import { becomes, root } from './service.mjs';

const services = [];
async function create(...options) {
  const service = new FaultyService(`239.255.79.${1 + services.length}`, ...options);
  services.push(service);
  await service.prepare();
  return service;
}
after(() => Promise.all(services.map((service) => service.remove())));

const picture = join(root, 'tests/golden/division_b.jpg');

describe('a camera that fails', () => {
  /** Each builds a source from a folder of its own. */
  const faults = {
    'is not there': (folder) => ({ backend: 'files', path: join(folder, 'not-there') }),
    'hangs when it is opened': (folder) => {
      execFileSync('mkfifo', [join(folder, 'silent.mp4')]);
      return { backend: 'files', path: join(folder, 'silent.mp4') };
    },
    'sends garbage': (folder) => {
      for (let i = 0; i < 5; i++) writeFileSync(join(folder, `${i}.jpg`), randomBytes(20_000));
      return { backend: 'files', path: folder, loop: true };
    },
    'sends garbage between pictures': (folder) => {
      copyFileSync(picture, join(folder, 'a.jpg'));
      writeFileSync(join(folder, 'b.jpg'), readFileSync(picture).subarray(0, 5000));
      writeFileSync(join(folder, 'c.png'), readFileSync(picture));
      writeFileSync(join(folder, 'd.ppm'), 'P6\n99999 99999\n255\n');
      writeFileSync(join(folder, 'e.jpg'), '');
      return { backend: 'files', path: folder, loop: true, frame_rate_hz: 100 };
    },
    'changes the size of its pictures all the time': (folder) => {
      for (const [i, [width, height]] of [[2, 2], [640, 2], [2, 480], [64, 48], [3, 5], [1000, 700]].entries()) {
        writeFileSync(join(folder, `${i}.ppm`), Buffer.concat([Buffer.from(`P6\n${width} ${height}\n255\n`), randomBytes(3 * width * height)]));
      }
      return { backend: 'files', path: folder, loop: true, frame_rate_hz: 100 };
    },
    'ends at once': (folder) => {
      writeFileSync(join(folder, 'one.ppm'), Buffer.concat([Buffer.from('P6\n8 8\n255\n'), randomBytes(192)]));
      return { backend: 'files', path: folder, frame_rate_hz: 0 };
    },
  };
  for (const [fault, make] of Object.entries(faults)) {
    it(`${fault}: the other loses no frame, and it comes back`, async () => {
      const service = await create({ cameras: [smallCamera(0, 60), smallCamera(1)] });
      const folder = join(service.folder, 'camera');
      mkdirSync(folder);
      const bad = make(folder), good = smallCamera(1).source;
      await service.start();
      const packets = await service.listen();
      await packets.more(1, 2);
      const rounds = tries(3, 40);
      const times = [];
      for (let round = 0; round < rounds; round++) {
        assert.equal((await service.set('/cameras/1/source', bad)).status, 200);
        await packets.more(0, 30);
        const mended = performance.now();
        assert.equal((await service.set('/cameras/1/source', good)).status, 200);
        await packets.more(1, 1);
        times.push(performance.now() - mended);
      }
      assert.equal((await service.get('healthz')), 'ok\n');
      packets.close();
      await service.stop();
      report(`a camera that ${fault}; frames of the other (${packets.of(0).length})`, rounds, packets.lost(0), times);
      assert.equal(packets.lost(0), 0);
    });
  }

  it('several that hang at once are waited for together when the service ends', async () => {
    const service = await create({ cameras: [0, 1, 2, 3].map((id) => smallCamera(id)) });
    for (const camera of service.settings.cameras.slice(0, 3)) {
      const pipe = join(service.folder, `${camera.id}.mp4`);
      execFileSync('mkfifo', [pipe]);
      camera.source = { backend: 'files', path: pipe };
    }
    service.writeSettings();
    await service.start();
    const packets = await service.listen();
    await packets.more(3, 2);
    const began = performance.now();
    await service.stop();
    const took = performance.now() - began;
    packets.close();
    report('SIGTERM while 3 of 4 cameras hang: until it has ended; frames of the fourth', 1, packets.lost(3), [took]);
    if (IS_TIMED) assert.ok(took < 3 * 1500, `${took} ms is one after the other`);
    assert.equal(packets.lost(3), 0);
  });
});

describe('a port that is taken', () => {
  it('is reported in one line, with an exit code that makes systemd retry', async () => {
    const service = await create();
    const rounds = tries(5, 50);
    const times = [];
    for (let round = 0; round < rounds; round++) {
      const other = createServer().listen(0, '127.0.0.1');
      await once(other, 'listening');
      service.settings.panel = { port: other.address().port, address: '127.0.0.1' };
      service.writeSettings();
      service.spawn();
      const { code } = await service.ended;
      assert.equal(code, 75, 'EX_TEMPFAIL');
      const said = service.log.filter((line) => line.startsWith('ssl-visiond: '));
      assert.deepEqual(said, [`ssl-visiond: ${service.settingsFile}: /panel/port: ${service.settings.panel.port} is taken by another program; stop that one or choose another port`]);
      other.close();
      await once(other, 'close');
      times.push(await service.start());
      await service.stop();
    }
    report('port taken at start, then free', rounds, null, times);
  });
});

describe('a clock that is set', { skip: existsSync(CLOCK) ? false : `${CLOCK} is not built` }, () => {
  it('by an hour, forth and back: frames, times, viewers and alerts go on', async () => {
    const service = await create({ cameras: [smallCamera(0, 60), smallCamera(1, 60)] });
    const file = join(service.folder, 'clock');
    const set = (hours) => {
      const offset = Buffer.alloc(8);
      offset.writeBigInt64LE(BigInt(hours) * 3_600_000_000_000n);
      writeFileSync(file, offset, { flag: existsSync(file) ? 'r+' : 'w' });
    };
    set(0);
    Object.assign(service.environment, { ...preload(CLOCK), SSLV_CLOCK_FILE: file });
    await service.start();
    const packets = await service.listen();
    const viewer = await openViewer(service.port, { camera: 0, width: 156, fps: 30 });
    await packets.more(0, 30);
    const rounds = tries(3, 60);
    const times = [];
    let astride = 0, uptime = 0, drops = 0;
    const now = async () => (await service.status()).time - Date.now() / 1000;
    const HALF_AN_HOUR_S = 1800; // tells the clocks apart, however late a packet is
    for (let round = 0; round < rounds; round++) {
      for (const hours of [1, 0, -1, 0]) {
        const before = packets.frames.length;
        set(hours);
        const began = performance.now();
        await becomes(now, (ahead_s) => Math.abs(ahead_s - hours * 3600) < HALF_AN_HOUR_S);
        await packets.more(0, 10);
        await packets.more(1, 10);
        // Frames in progress during the clock change may have one time from each clock; no later frame may.
        const since = packets.frames.slice(before);
        const isTorn = ({ capture_s, sent_s }) => Math.abs(sent_s - capture_s) > HALF_AN_HOUR_S;
        const isRight = ({ sent_s, capture_s }) => sent_s - capture_s >= -0.001 && !isTorn({ capture_s, sent_s }) && Math.abs(sent_s - Date.now() / 1000 - hours * 3600) < HALF_AN_HOUR_S;
        for (const camera of [0, 1]) {
          const its = since.filter((frame) => frame.camera === camera);
          const first = its.findIndex(isRight);
          assert.ok(first >= 0 && its.slice(first).every(isRight), `camera ${camera} at ${hours} h: ${JSON.stringify(its)}`);
        }
        astride += since.filter(isTorn).length;
        times.push(since.find(isRight).at_ms - began);
        const pictures = viewer.pictures;
        await becomes(() => viewer.pictures, (count) => count > pictures);
        const status = await service.status();
        assert.ok(status.uptime_s >= uptime && status.uptime_s < uptime + HALF_AN_HOUR_S, `up for ${status.uptime_s} s after ${uptime} s`);
        uptime = status.uptime_s;
        for (const { id, since: since_s } of status.alerts) {
          // Alerts that do not depend on the clock: this computer's, and cameras that all see one half. For ten seconds
          // the field also reports wrong times, because of the frames that were in progress during the change.
          assert.ok(['frames_dropped', 'latency_high', 'stage_slow', 'camera_slow', 'only_this_computer', 'field_uncovered', 'camera_off_time'].includes(id), id);
          assert.ok(since_s <= status.time && since_s > status.time - HALF_AN_HOUR_S, `${id} since ${since_s}, now ${status.time}`);
        }
        for (const { id, state, reconnects, frames_dropped: dropped } of status.cameras) {
          assert.deepEqual([state, reconnects], ['running', 0], `camera ${id}`);
          assert.ok(dropped < 100_000, `camera ${id}: ${dropped} dropped: an hour of pictures`);
          drops = Math.max(drops, dropped);
        }
        assert.equal(await service.get('healthz'), 'ok\n');
        assert.equal((await service.set('/site', `Hour ${hours}, ${round}`)).status, 200);
        // The timeline gets an entry once a second.
        await becomes(() => service.get('api/timeline?seconds=60'), ({ time_s: seconds }) => seconds.every((time_s, i) => Math.abs(time_s - status.time) < HALF_AN_HOUR_S && (i === 0 || time_s > seconds[i - 1])));
      }
    }
    await becomes(() => service.status(), ({ alerts }) => !alerts.some(({ id }) => id === 'camera_off_time'));
    const lost = packets.lost(0, 1);
    viewer.end();
    packets.close();
    await service.stop();
    report(`clock set by an hour, forth and back (${packets.frames.length} frames, ${astride} with t_capture and t_sent on either side)`, 4 * rounds, lost, times);
    assert.equal(lost, 0);
  });
});

describe('a network card that is taken out', { skip: cannotUnshare() }, () => {
  it('and put back: multicast goes on, and an alert says so meanwhile', async (t) => {
    // In its own network namespace, together with its client.
    const script = fileURLToPath(new URL('faults_network.mjs', import.meta.url));
    const inner = spawn('unshare', ['--net', process.execPath, script], { stdio: 'inherit' });
    const [code] = await once(inner, 'exit');
    if (code === 77) return t.skip('the kernel has no network cards to play with (veth)');
    assert.equal(code, 0);
  });
});

describe('a signal at any moment of the start', () => {
  const OWN_SIGNALS = (1n << 0n) | (1n << 1n) | (1n << 14n); // SIGHUP, SIGINT, SIGTERM

  /** Busy-waits, as the start takes only a few milliseconds. Returns whether the process got that far. */
  function waitForFirstInstruction(pid) {
    for (;;) {
      let blocked;
      try {
        blocked = /SigBlk:\s+([0-9a-f]+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))?.[1];
      } catch {
        return false;
      }
      if (blocked !== undefined && BigInt(`0x${blocked}`) === OWN_SIGNALS) return true;
    }
  }
  const wait = (ms) => {
    for (const end = performance.now() + ms; performance.now() < end;);
  };

  it('SIGTERM ends it cleanly, SIGHUP never does', async () => {
    const service = await create({ cameras: [smallCamera(0), smallCamera(1)] });
    const starts = [];
    for (let i = 0; i < 5; i++) {
      starts.push(await service.start());
      await service.stop();
    }
    const longest = 1.5 * Math.max(...starts);
    const rounds = tries(15, 300);
    const ends = [], readies = [];
    for (let round = 0; round < rounds; round++) {
      const delay = longest * (round + Math.random()) / rounds; // covers every moment over all rounds
      service.spawn();
      assert.ok(waitForFirstInstruction(service.process.pid));
      wait(delay);
      const began = performance.now();
      const { code, signal } = await service.kill('SIGTERM');
      ends.push(performance.now() - began);
      assert.deepEqual([code, signal], [0, null], `SIGTERM ${delay} ms after the first instruction:\n${service.log.join('\n')}`);
      if (IS_TIMED) assert.ok(ends.at(-1) < 2000, `${ends.at(-1)} ms`);

      service.spawn();
      assert.ok(waitForFirstInstruction(service.process.pid));
      const spawned = performance.now();
      wait(delay);
      service.process.kill('SIGHUP');
      service.port = await service.ready;
      readies.push(performance.now() - spawned);
      await becomes(() => service.log, (log) => log.some((line) => /settings file reloaded/.test(line)));
      assert.equal((await service.get('api/settings')).revision, 1);
      await service.stop();
    }
    report(`SIGTERM 0 to ${longest.toFixed(0)} ms after the first instruction: until it has ended, always with 0`, rounds, null, ends);
    report('SIGHUP at the same moments: until it is ready', rounds, null, readies);
  });
});
