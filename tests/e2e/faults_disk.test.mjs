// SPDX-License-Identifier: Apache-2.0
// Confirmed saves are never lost and refused changes never kept, whatever the disk does and whenever the service is
// killed.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { chmodSync, existsSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, describe, it } from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { openViewer } from '../figures/viewer.mjs';
import { cannotUnshare, FaultyService, HUNG_DISK, preload, report, smallCamera, tries } from './faults.mjs';
import { becomes, freeUdpPort } from './service.mjs';

const services = [];
async function create(...options) {
  const service = new FaultyService(`239.255.78.${1 + services.length}`, ...options);
  services.push(service);
  await service.prepare();
  return service;
}
after(() => Promise.all(services.map((service) => service.remove())));

const cyanCells = async (service) => (await service.get('api/cameras/0/colors')).labels.find(({ name }) => name === 'cyan').cells;

describe('killed while it saves', () => {
  it('loses nothing that was reported as saved, and its files are intact', async () => {
    const service = await create();
    const rounds = tries(40, 500);
    const starts = [];
    let site = 0, revision = 0, painted = 0, saves = 0;
    // Allowed after a kill: the last confirmed value, or a later one that was requested.
    const profiles = Array.from({ length: 4 }, () => ({ answered: 0, asked: 0 }));
    const sites = { answered: 0, asked: 0 };
    const tables = { answered: 0, asked: 0 };

    const writers = {
      async settings() {
        sites.asked = ++site;
        const { json } = await service.set('/site', `site ${site}`);
        assert.equal(json.saved, true);
        sites.answered = sites.asked;
        assert.ok(json.revision > revision);
        revision = json.revision;
      },
      async profile(place) {
        const one = profiles[place];
        one.asked++;
        await service.good('PUT', `api/profiles/p${place}`, { settings: { site: `profile ${one.asked}` } });
        one.answered = one.asked;
      },
      // Each edit paints one more cell, different from the earlier ones.
      async table() {
        const n = painted++;
        tables.asked++;
        await service.good('POST', 'api/cameras/0/colors/edits', {
          commands: [{ op: 'paint', label: 'cyan', shape: 'box', at: [8 + 16 * (n % 15), 8 + 16 * (Math.floor(n / 15) % 15), 8 + 16 * (Math.floor(n / 225) % 15)], radius: [1, 1, 1] }],
        });
        tables.answered = tables.asked;
      },
    };
    let cells = null;
    let lost = 0; // confirmed saves that are missing
    const isThere = (found, { answered, asked }, what) => {
      lost += Math.max(0, answered - found);
      assert.ok(found <= asked, `${what}: ${found}, though only ${asked} was asked for`);
    };
    for (let round = 0; round < rounds; round++) {
      starts.push(await service.start());
      const now = await service.get('api/settings');
      lost += Math.max(0, revision - now.revision);
      revision = now.revision;
      const shown = Number(/^site (\d+)$/.exec(now.settings.site)?.[1] ?? 0);
      isThere(shown, sites, 'the site');
      const { profiles: names } = await service.get('api/profiles').then((json) => ({ profiles: json.profiles ?? json }));
      for (const [place, one] of profiles.entries()) {
        if (one.asked === 0) continue;
        if (!names.some(({ name }) => name === `p${place}`)) {
          lost += one.answered;
          continue;
        }
        const kept = Number(/(\d+)$/.exec((await service.get(`api/profiles/p${place}`)).settings.site)[1]);
        isThere(kept, one, `profile p${place}`);
        one.answered = one.asked = kept;
      }
      const cyan = await cyanCells(service);
      cells ??= cyan;
      // Each edit adds new cells; edits that were not confirmed may be missing or present.
      assert.ok(cyan >= cells, `${cyan} cells, there were ${cells}`);
      if (painted < 3000 && tables.each !== undefined) isThere((cyan - cells) / tables.each, tables, 'painted cells');
      cells = cyan;
      Object.assign(tables, { answered: 0, asked: 0 });
      assert.deepEqual((await service.alerts()).filter((id) => /settings|table|state/.test(id)), []);
      if (tables.each === undefined) {
        await writers.table();
        tables.each = (await cyanCells(service)) - cells;
        assert.ok(tables.each > 0);
      }
      // No temporary files remain; the alert history is written from time to time.
      await becomes(() => service.stateFiles().filter((name) => /\.(new|old|rejected.*)$/.test(name)), (names) => names.length === 0);

      let killed = false;
      const keepOn = async (write) => {
        for (let i = 0; !killed; i++) {
          try {
            await write(i);
            saves++;
          } catch (error) {
            if (!killed || error.code === 'ERR_ASSERTION') throw error;
          }
        }
      };
      const busy = [keepOn(writers.settings), keepOn((i) => writers.profile(i % profiles.length)), keepOn(writers.table)];
      await Promise.race([pause(5 + Math.random() * 60), ...busy]);
      killed = true;
      await service.kill('SIGKILL');
      await Promise.all(busy);
      service.stateFiles(); // throws if a JSON file is incomplete
    }
    await service.start();
    await service.stop();
    report(`kill -9 during saves (settings, profiles, colour tables; ${saves} saves answered)`, rounds, lost, starts);
    assert.equal(lost, 0);
  });
});

describe('a disk that is full, or cannot be written', { skip: cannotUnshare() }, () => {
  const onDisk = (service, ...words) => execFileSync('nsenter', ['-t', String(service.process.pid), '-m', ...words], { stdio: 'pipe' });
  const inNamespace = (mount) => ['unshare', '--mount', '--propagation', 'private', 'sh', '-c', `${mount}; exec "$@"`, 'sh'];

  /** Each write is refused with the file and the reason, and changes nothing. */
  async function refusesAll(service, why) {
    const before = await service.get('api/settings');
    const cells = await cyanCells(service);
    const tried = [
      ['PATCH', 'api/settings', [{ op: 'replace', path: '/site', value: 'Refused' }], 'settings.json'],
      ['PUT', 'api/profiles/refused', undefined, 'profiles.json'],
      ['DELETE', 'api/profiles/kept', undefined, 'profiles.json'],
      ['POST', 'api/cameras/0/colors/edits', { commands: [{ op: 'paint', label: 'cyan', shape: 'box', at: [200, 200, 200], radius: [30, 30, 30] }] }, 'tables/'],
    ];
    for (const [method, path, body, file] of tried) {
      const { status, json } = await service.ask(method, path, body);
      assert.equal(status, 507, `${method} ${path}: ${JSON.stringify(json).slice(0, 300)}`);
      assert.match(json.error, why);
      assert.ok(json.error.includes(join(service.state, file)), json.error);
    }
    const alert = await service.alertComes('settings_not_saved');
    assert.match(alert.title, why);
    assert.deepEqual(await service.get('api/settings'), before);
    assert.equal(await cyanCells(service), cells);
    assert.equal((await service.ask('GET', 'api/profiles/refused')).status, 404);
    assert.equal((await service.ask('GET', 'api/profiles/kept')).status, 200);
  }

  async function savesAll(service, site) {
    assert.equal((await service.set('/site', site)).status, 200);
    await service.good('PUT', 'api/profiles/kept');
    await service.good('POST', 'api/cameras/0/colors/edits', { commands: [{ op: 'paint', label: 'cyan', shape: 'box', at: [9 + 8 * Math.floor(Math.random() * 30), 100, 100], radius: [1, 1, 1] }] });
    await service.alertGoes('settings_not_saved');
    await service.alertGoes('state_not_writable');
  }

  for (const [fault, break_, mend, why, alert] of [
    ['disk full', (s) => onDisk(s, 'sh', '-c', `dd if=/dev/zero of=${s.state}/filler bs=4k 2>/dev/null || true`), (s) => onDisk(s, 'rm', join(s.state, 'filler')), /No space left on device/, 'disk_full'],
    ['disk read-only', (s) => onDisk(s, 'mount', '-o', 'remount,ro', s.state), (s) => onDisk(s, 'mount', '-o', 'remount,rw', s.state), /Read-only file system/, 'state_not_writable'],
  ]) {
    it(`${fault}: refuses, says so, and saves again without a restart`, async () => {
      const service = await create();
      service.wrap = inNamespace(`mkdir -p ${service.state} && mount -t tmpfs -o size=6m none ${service.state}`);
      await service.start();
      const packets = await service.listen();
      await packets.more(0, 3);
      const rounds = tries(3, 50);
      const times = [];
      for (let round = 0; round < rounds; round++) {
        await savesAll(service, `Round ${round}`);
        const file = () => onDisk(service, 'cat', join(service.state, 'settings.json')).toString();
        const before = file();
        break_(service);
        await refusesAll(service, why);
        await service.alertComes(alert);
        assert.equal(file(), before);
        mend(service);
        const mended = performance.now();
        assert.equal((await service.set('/site', 'Mended')).status, 200);
        times.push(performance.now() - mended);
        assert.equal(JSON.parse(file()).revision, (await service.get('api/settings')).revision);
        await packets.more(0, 3);
      }
      const lost = packets.lost(0);
      // The alert history is written from time to time.
      await becomes(() => onDisk(service, 'ls', service.state).toString().split('\n').filter((name) => /new|old|rejected/.test(name)), (names) => names.length === 0);
      packets.close();
      await service.stop();
      report(`${fault}, ${4 * rounds} writes refused`, rounds, lost, times);
      assert.equal(lost, 0, 'frames go on meanwhile');
    });
  }

  it('ends a match log when it is full, and costs no image', async () => {
    const service = await create();
    service.wrap = inNamespace(`mkdir -p ${service.state} && mount -t tmpfs -o size=6m none ${service.state}`);
    await service.start();
    assert.match((await service.alertComes('recording_disk')).title, /keep_free_mb/);
    assert.equal((await service.set('/recording/keep_free_mb', 0)).status, 200);
    await service.alertGoes('recording_disk');
    const packets = await service.listen();
    await packets.more(0, 3);
    const record = () => service.ask('POST', 'api/recordings/match-log', { record: true, name: 'full' });
    const { json: { match_log: { name } } } = await record();
    await becomes(() => service.get('api/recordings'), ({ match_log }) => match_log.bytes > 2000);
    onDisk(service, 'sh', '-c', `dd if=/dev/zero of=${service.state}/filler bs=4k 2>/dev/null || true`);
    assert.match((await service.alertComes('recording_failed')).title, /No space left on device/);
    assert.equal((await service.get('api/recordings')).match_log.state, 'failed');
    await packets.more(0, 3);
    onDisk(service, 'rm', join(service.state, 'filler'));
    const log = await becomes(async () => (await service.get('api/recordings')).logs.find((one) => one.name === name), (one) => one.seconds !== null);
    assert.equal(log.problem, '', 'what was written before is whole');
    assert.ok(log.messages.vision > 0);
    assert.equal((await record()).status, 200);
    await service.alertGoes('recording_failed');
    await packets.more(0, 3);
    assert.equal(packets.lost(0), 0);
    packets.close();
    await service.stop();
  });

  it('runs without a state folder, and saves once there may be one', async () => {
    const service = await create();
    const parent = join(service.folder, 'parent');
    service.wrap = inNamespace(`mkdir -p ${parent} && mount -t tmpfs -o ro none ${parent}`);
    service.state = join(parent, 'state');
    await service.start();
    const alert = await service.alertComes('state_not_writable');
    assert.ok(alert.title.includes(service.state) && /Read-only file system/.test(alert.title), alert.title);
    const packets = await service.listen();
    await packets.more(0, 3);
    packets.close();
    const { status, json } = await service.set('/site', 'Lost');
    assert.equal(status, 507);
    assert.match(json.error, /Read-only file system/);
    onDisk(service, 'mount', '-o', 'remount,rw', parent);
    assert.equal((await service.set('/site', 'Kept')).status, 200);
    await service.alertGoes('state_not_writable');
    await service.alertGoes('settings_not_saved');
    await service.stop();
  });
});

describe("the admin's file", () => {
  it('is never written, nor is its folder', async () => {
    const service = await create();
    service.writeSettings(`${JSON.stringify(service.settings, null, 3)}\n\n`);
    const look = () => [createHash('sha256').update(readFileSync(service.settingsFile)).digest('hex'), statSync(service.settingsFile).mtimeMs, readdirSync(service.folder).filter((name) => name !== 'state').join()];
    const before = look();
    chmodSync(service.settingsFile, 0o444);
    // A read-only mount for root, who is not bound by permissions.
    if (!cannotUnshare()) service.wrap = ['unshare', '--mount', '--propagation', 'private', 'sh', '-c', 'mkdir -p "$0" && mount --bind "$1" "$1" && mount --bind "$0" "$0" && mount -o remount,bind,ro "$1"; shift; exec "$@"', service.state, service.folder];
    await service.start();
    for (const [path, value] of [['/site', 'Hall 2'], ['/cameras/0/name', 'left'], ['/field/field_length', 6000]]) assert.equal((await service.set(path, value)).status, 200);
    await service.good('PUT', 'api/profiles/one');
    await service.good('POST', 'api/settings/undo', { revision: 2 });
    assert.notEqual((await service.get('api/settings')).settings.site, 'Hall 2', 'taken back');
    service.process.kill('SIGHUP');
    await becomes(() => service.log.join('\n'), (log) => /settings file reloaded/.test(log));
    await service.stop();
    assert.deepEqual(look(), before);
    assert.ok(existsSync(join(service.state, 'settings.json')));
  });

  it('is reloaded at SIGHUP, or refused with one line and an alert', async () => {
    const service = await create();
    await service.start();
    const name = 'sslv_config_last_reload_success_timestamp_seconds';
    const reloaded_s = async () => Number(new RegExp(`^${name} (\\S+)$`, 'm').exec(await service.get('metrics'))[1]);
    assert.equal((await service.set('/cameras/0/name', 'by the panel')).status, 200);
    const packets = await service.listen();
    await packets.more(0, 2);

    const rounds = tries(10, 200);
    const times = [];
    for (let round = 1; round <= rounds; round++) {
      service.settings.site = `Site ${round}`;
      service.writeSettings();
      const before_s = await reloaded_s();
      const began = performance.now();
      service.process.kill('SIGHUP');
      const { settings } = await becomes(() => service.get('api/settings'), ({ settings: now }) => now.site === `Site ${round}`);
      times.push(performance.now() - began);
      assert.equal(settings.cameras[0].name, 'by the panel', 'what the panel changed stays on top');
      await becomes(reloaded_s, (now_s) => now_s > before_s);

      const good_s = await reloaded_s();
      for (const [text, why] of [['{"site": ', /line 1, column 10/], ['{"site": 7}', /\/site: 7 is not allowed/], ['{"version": 99}', /\/version: 99 is newer/], ['{"cameras": []}', /together with the panel's changes/]]) {
        service.writeSettings(text);
        const lines = service.log.length;
        service.process.kill('SIGHUP');
        await becomes(() => service.log.slice(lines), (log) => log.some((line) => why.test(line)));
        const said = service.log.slice(lines).filter((line) => line.includes(service.settingsFile));
        assert.equal(said.length, 1, said.join('\n'));
        const alert = await becomes(service.status, ({ alerts }) => alerts.some(({ id, title }) => id === 'settings_not_reloaded' && why.test(title)));
        assert.equal(alert.settings_revision, 2 + round);
        assert.equal((await service.get('api/settings')).settings.site, `Site ${round}`);
        assert.equal(await reloaded_s(), good_s);
      }
      service.writeSettings();
      service.process.kill('SIGHUP');
      await service.alertGoes('settings_not_reloaded');
      assert.equal((await service.get('api/settings')).revision, 2 + round, 'a reload of what is in force is no step');
    }
    await packets.more(0, 2);
    const lost = packets.lost(0);
    packets.close();
    await service.stop();
    await service.start();
    const { settings, revision } = await service.get('api/settings');
    assert.deepEqual([settings.site, settings.cameras[0].name, revision], [`Site ${rounds}`, 'by the panel', 2 + rounds]);
    await service.stop();
    report(`SIGHUP with a new file, and with ${4 * rounds} wrong ones between`, rounds, lost, times);
    assert.equal(lost, 0);
  });
});

describe('many changes', () => {
  it('under load: no change and no frame is lost, and memory is freed', async () => {
    const service = await create({ cameras: [smallCamera(0, 60), smallCamera(1, 60)] });
    await service.start();
    const packets = await service.listen();
    const viewers = [];
    for (const camera of [0, 1, 1]) viewers.push(await openViewer(service.port, { camera, width: 156, fps: 30 }));
    const rss_kB = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${service.process.pid}/status`, 'utf8'))[1]);
    const count = tries(200, 1000);
    const changes = [
      (n) => ['/site', `Site ${n}`],
      (n) => ['/field/field_length', 9000 + n % 100],
      (n) => ['/cameras/0/name', `name ${n}`],
      (n) => ['/cameras/1/stages/detect_balls/max_balls', 1 + n % 20],
      (n) => ['/cameras/0/mask/exclude', [{ points: [[0, 0], [9, 0], [9, 1 + n % 50]] }]],
      (n) => ['/teams/yellow/robot_height', 140 + n % 10],
    ];
    const last = new Map();
    const times = [];
    let before_kB = 0;
    let revision = (await service.get('api/settings')).revision;
    const warm = Math.floor(0.4 * count); // history and caches are full by then
    await packets.more(0, 5);
    const dropped = async () => (await service.status()).cameras.reduce((sum, { frames_dropped: n }) => sum + n, 0);
    const droppedBefore = await dropped();
    for (let n = 0; n < count; n++) {
      const [path, value] = changes[n % changes.length](n);
      const began = performance.now();
      const { status, json } = await service.set(path, value);
      times.push(performance.now() - began);
      assert.equal(status, 200, JSON.stringify(json).slice(0, 300));
      assert.equal(json.revision, ++revision);
      last.set(path, value);
      if (n === warm) before_kB = rss_kB();
    }
    const after_kB = rss_kB();
    const valueAt = (tree, path) => path.split('/').slice(1).reduce((at, key) => at[key], tree);
    const { settings } = await service.get('api/settings');
    for (const [path, value] of last) assert.deepEqual(valueAt(settings, path), value, path);
    const saved = JSON.parse(readFileSync(join(service.state, 'settings.json'), 'utf8'));
    assert.equal(saved.revision, revision);
    assert.ok(saved.history.length <= 300 && saved.history.length > Math.min(299, count - 1), `${saved.history.length} steps`);
    // The allocator's arenas fill unevenly; a leak at each change would exceed this margin.
    assert.ok(after_kB < before_kB * 1.3 + 4096, `${before_kB} kB, then ${after_kB} kB`);
    await packets.more(0, 5);
    await packets.more(1, 5);
    const lost = packets.lost(0, 1);
    assert.ok(viewers.every(({ pictures }) => pictures > 0));
    for (const viewer of viewers) viewer.end();
    packets.close();
    const drops = (await dropped()) - droppedBefore;
    await service.stop();
    await service.start();
    const again = await service.get('api/settings');
    assert.equal(again.revision, revision);
    for (const [path, value] of last) assert.deepEqual(valueAt(again.settings, path), value, path);
    await service.stop();
    report(`settings changed under load (2 cameras at 60/s, 3 viewers; ${packets.frames.length} frames, ${drops} not taken in time; RSS ${(before_kB / 1024).toFixed(0)} then ${(after_kB / 1024).toFixed(0)} MiB)`, count, lost, times);
    assert.equal(lost, 0, 'no number of a frame is missing');
  });
});

describe('a disk that hangs', { skip: existsSync(HUNG_DISK) ? false : `${HUNG_DISK} is not built` }, () => {
  it('loses messages of the match log, which is reported, and no image', async () => {
    const service = await create();
    const hung = join(service.folder, 'hung');
    Object.assign(service.environment, {
      ...preload(HUNG_DISK), SSLV_HUNG_FOLDER: join(service.state, 'recordings'), SSLV_HUNG_WHILE: hung, ASAN_OPTIONS: 'verify_asan_link_order=0',
    });
    const [group, port] = ['239.255.78.99', await freeUdpPort()];
    service.settings.network.tracker = { enabled: false, group, port };
    service.writeSettings();
    await service.start();
    const packets = await service.listen();
    const { json: { match_log: { name } } } = await service.ask('POST', 'api/recordings/match-log', { record: true, name: 'hung' });
    await becomes(() => service.get('api/recordings'), ({ match_log }) => match_log.messages.vision > 3);
    assert.ok(!(await service.alerts()).includes('recording_lost'));
    writeFileSync(hung, '');
    await becomes(() => existsSync(`${hung}.reached`), (reached) => reached);

    // Sends more tracker data than can be buffered until the disk is back.
    const sender = createSocket('udp4').bind(0, '127.0.0.1');
    await once(sender, 'listening');
    sender.setMulticastInterface('127.0.0.1');
    // A TrackerWrapperPacket: uuid "a", a name of 50,000 bytes, a frame with its number and time.
    const large = Buffer.concat([Buffer.from([0x0a, 1, 0x61, 0x12, 0xd0, 0x86, 3]), Buffer.alloc(50_000, 'x'), Buffer.from([0x1a, 11, 8, 1, 0x11, ...Buffer.alloc(8)])]);
    const lost = async () => {
      for (let i = 0; i < 40; i++) await new Promise((sent) => { sender.send(large, port, group, sent); });
      return (await service.status()).alerts.find(({ id }) => id === 'recording_lost');
    };
    const alert = await becomes(lost, (found) => found !== undefined);
    sender.close();
    assert.match(alert.title, /^The match log lacks \d+ messages: the disk was too slow, or too much was sent$/);
    assert.deepEqual([alert.severity, alert.page], ['warn', '#/recordings']);
    await packets.more(0, 10); // processing continues meanwhile

    rmSync(hung);
    const { match_log: now } = await service.get('api/recordings');
    assert.equal(now.state, 'recording', now.error);
    assert.ok(now.lost > 0);
    // New messages are recorded.
    await becomes(() => service.get('api/recordings'), ({ match_log }) => match_log.messages.vision > now.messages.vision + 5);
    await service.good('POST', 'api/recordings/match-log', { record: false });
    await service.alertGoes('recording_lost');
    const log = await becomes(async () => (await service.get('api/recordings')).logs.find((one) => one.name === name), (one) => one.seconds !== null);
    assert.equal(log.problem, '');
    assert.ok(log.messages.vision > now.messages.vision);
    assert.equal(packets.lost(0), 0);
    packets.close();
    await service.stop();
  });
});
