// SPDX-License-Identifier: Apache-2.0
// The history of alerts and actions, read from the running service: across a lost camera, a kill, a stop, a full disk
// and a clock change.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, describe, it } from 'node:test';
import { cannotUnshare, CLOCK, FaultyService, preload, smallCamera } from './faults.mjs';
import { becomes, DAEMON } from './service.mjs';

const CTL = process.env.SSLV_CTL ?? join(DAEMON, '../ssl-visionctl');

const services = [];
async function create(...options) {
  const service = new FaultyService(`239.255.79.${1 + services.length}`, ...options);
  services.push(service);
  await service.prepare();
  return service;
}
after(() => Promise.all(services.map((service) => service.remove())));

const events = (service) => service.get('api/events');
const entries = async (service) => (await events(service)).entries;
const entriesBecome = (service, wanted) => becomes(() => entries(service), wanted);
const of = (all, id) => all.filter((entry) => entry.id === id);
const lostOf = (all) => of(all, 'camera_lost');
/** The history that would survive if the service died now. */
const saved = (service) => {
  const file = join(service.state, 'events.json');
  return existsSync(file) ? JSON.parse(readFileSync(file, 'utf8')).entries : [];
};

const loseCamera = (service) => service.set('/cameras/0/source', { backend: 'files', path: join(service.folder, 'not-there') });
const haveCamera = (service) => service.set('/cameras/0/source', service.settings.cameras[0].source);

describe('the history of alerts and events', () => {
  it('says when a camera was lost, for how long, and what was done', async () => {
    const service = await create();
    await service.start();
    await entriesBecome(service, (all) => of(all, 'service_started').length === 1);
    await loseCamera(service);
    const [open] = lostOf(await entriesBecome(service, (all) => lostOf(all).some(({ seconds }) => seconds >= 2)));
    assert.deepEqual([open.kind, open.severity, open.camera, open.end, open.count], ['alert', 'bad', 0, null, 1]);
    assert.match(open.title, /not-there/);
    await haveCamera(service);
    const all = await entriesBecome(service, (now) => lostOf(now)[0].end !== null);
    const [lost] = lostOf(all);
    assert.equal(lost.ended_by, '');
    assert.ok(lost.seconds >= open.seconds && Math.abs(lost.end - lost.begin - lost.seconds) < 0.5, JSON.stringify(lost));
    const changes = of(all, 'settings_changed');
    assert.ok(changes.length >= 1 && changes.every(({ who, title }) => who === '127.0.0.1' && title.includes('/cameras/0/source')), JSON.stringify(changes));
    assert.equal(of(all, 'camera_reopened')[0].camera, 0);
    for (const [i, { seq }] of all.entries()) assert.ok(i === 0 || seq < all[i - 1].seq, 'newest first');

    const told = (...words) => execFileSync(CTL, ['--daemon', `http://127.0.0.1:${service.port}`, 'events', ...words], { encoding: 'utf8' });
    assert.match(told(), /bad +Camera 0 is lost.*not-there/);
    assert.match(told(), /Settings changed: \/cameras\/0\/source.* by 127\.0\.0\.1/);
    assert.match(told('--bad'), /^began +lasted +severity +what\n(.*\n)*.*Camera 0 is lost/); // a busy computer may add newer entries
    assert.doesNotMatch(told('--bad'), /Settings changed/);
    const json = JSON.parse(told('--bad', '--json'));
    assert.ok(json.entries.length >= 1 && json.entries.every(({ severity }) => severity === 'bad'));
    await service.stop();
  });

  it('survives a kill: open alerts end with the service', async () => {
    const service = await create();
    await service.start();
    await loseCamera(service);
    await becomes(() => saved(service), (all) => lostOf(all).length === 1 && of(all, 'settings_changed').length === 1);
    await service.kill('SIGKILL');
    await service.start();
    const all = await entriesBecome(service, (now) => of(now, 'service_restarted').length === 1 && lostOf(now).length === 2);
    const [again, before] = lostOf(all);
    assert.equal(again.end, null, 'it is still lost');
    assert.equal(before.ended_by, 'the service ended');
    assert.ok(before.end >= before.begin && before.end <= again.begin, JSON.stringify([before, again]));
    assert.equal(of(all, 'service_stopped').length, 0);
    assert.match(of(all, 'service_restarted')[0].title, /ended without a stop/);

    await service.stop();
    await service.start();
    const later = await entriesBecome(service, (now) => of(now, 'service_started').length === 2);
    assert.equal(of(later, 'service_stopped').length, 1);
    assert.ok(lostOf(later).filter(({ ended_by: why }) => why === 'the service ended').length === 2);
    await service.stop();
  });

  it('starts empty, with one line, where its file is damaged', async () => {
    const service = await create();
    await service.start();
    await becomes(() => saved(service), (all) => all.length > 0);
    await service.stop();
    const file = join(service.state, 'events.json');
    writeFileSync(file, readFileSync(file, 'utf8').slice(0, -20));
    await service.start();
    const lines = await becomes(() => service.log.filter((line) => line.includes('events.json')), ({ length }) => length > 0);
    assert.equal(lines.length, 1, lines.join('\n'));
    assert.match(lines[0], /warn.*the history of alerts starts empty: .*events\.json/);
    const all = await entriesBecome(service, (now) => now.length > 0);
    assert.equal(of(all, 'service_stopped').length, 0);
    assert.equal((await service.get('healthz')), 'ok\n');
    await service.stop();
  });

  it('keeps durations when the clock is set', { skip: existsSync(CLOCK) ? false : `${CLOCK} is not built` }, async () => {
    const service = await create();
    const file = join(service.folder, 'clock');
    const set = (hours) => {
      const offset = Buffer.alloc(8);
      offset.writeBigInt64LE(BigInt(hours) * 3_600_000_000_000n);
      writeFileSync(file, offset, { flag: existsSync(file) ? 'r+' : 'w' });
    };
    set(0);
    Object.assign(service.environment, { ...preload(CLOCK), SSLV_CLOCK_FILE: file });
    await service.start();
    const began = performance.now();
    await loseCamera(service);
    await entriesBecome(service, (all) => lostOf(all).length === 1);
    for (const [hours, words] of [[1, 'forward by 1 h'], [-1, 'back by 2 h']]) {
      set(hours);
      const all = await entriesBecome(service, (now) => of(now, 'clock_set').some(({ title }) => title.includes(words)));
      const [lost] = lostOf(all);
      assert.ok(lost.seconds <= (performance.now() - began) / 1000 + 1, `${lost.seconds} s`);
      assert.ok(Math.abs(lost.begin - Date.now() / 1000 - hours * 3600) < 600, 'as the clock has it now');
    }
    await service.stop();
  });

  it('is kept in memory while the disk is full, and saved afterwards', { skip: cannotUnshare() }, async () => {
    const service = await create();
    const onDisk = (...words) => execFileSync('nsenter', ['-t', String(service.process.pid), '-m', ...words], { stdio: 'pipe' }).toString();
    service.wrap = ['unshare', '--mount', '--propagation', 'private', 'sh', '-c', `mkdir -p ${service.state} && mount -t tmpfs -o size=6m none ${service.state}; exec "$@"`, 'sh'];
    await service.start();
    const packets = await service.listen();
    await becomes(() => onDisk('ls', service.state), (names) => names.includes('events.json'));
    onDisk('sh', '-c', `dd if=/dev/zero of=${service.state}/filler bs=4k 2>/dev/null || true`);
    // Makes an event, so that there is something to save.
    assert.equal((await service.set('/site', 'Refused')).status, 507);
    const { save_problem: problem, entries: now } = await becomes(() => events(service), ({ save_problem: one, entries: all }) => one !== '' && of(all, 'settings_not_saved').length === 1);
    assert.match(problem, /events\.json.*No space left on device/);
    assert.ok(of(now, 'service_started').length === 1);
    const said = () => service.log.filter((line) => /the history of alerts is/.test(line));
    await becomes(said, ({ length }) => length === 1);
    await packets.more(0, 10);
    assert.equal(packets.lost(0), 0);
    await becomes(() => onDisk('ls', service.state).split('\n').filter((name) => /new|old|rejected/.test(name)), (names) => names.length === 0);

    onDisk('rm', join(service.state, 'filler'));
    assert.equal((await service.set('/site', 'Kept')).status, 200);
    await service.alertGoes('settings_not_saved');
    packets.close();
    await service.kill('SIGTERM');
    assert.deepEqual(said().map((line) => / saved again/.test(line)), [false, true], 'at its end at the latest');
  });

  it('says in the log how many images were lost', async () => {
    const service = await create({ cameras: [smallCamera(0, 30)] });
    await service.start();
    await becomes(() => service.status(), ({ cameras }) => cameras[0].frames > 30);
    // While the service is stopped, the simulated camera continues.
    service.process.kill('SIGSTOP');
    const before = Date.now();
    await becomes(() => Date.now() - before, (ms) => ms > 1500);
    service.process.kill('SIGCONT');
    const [line] = await becomes(() => service.log.filter((one) => /camera 0: \d+ of \d+ images lost/.test(one)), (lines) => lines.length > 0);
    const [, lost, dropped] = /camera 0: (\d+) of \d+ images lost in the last \d+ s: (\d+) were not processed in time, \d+ arrived damaged/.exec(line);
    const { cameras } = await service.status();
    assert.ok(Number(lost) >= Number(dropped) && Number(dropped) > 0 && Number(dropped) <= cameras[0].frames_dropped, `${line}; ${cameras[0].frames_dropped}`);
    await service.stop();
  });
});
