// SPDX-License-Identifier: Apache-2.0
// Stage libraries with the real service: correct ones, faulty ones and missing ones.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, beforeEach, describe, it } from 'node:test';
import { becomes, createService, DAEMON, root } from './service.mjs';

const LIBRARIES = process.env.SSLV_KIT_LIBRARIES ?? join(root, 'build/release/kit');
const service = await createService('239.255.77.92');
const folder = join(service.folder, 'stages');
const put = (name) => copyFileSync(join(LIBRARIES, name, `${name}.so`), join(folder, `${name}.so`));
const ask = async (path) => (await fetch(service.address(path))).json();
const patch = (...operations) => fetch(service.address('api/settings'), { method: 'PATCH', body: JSON.stringify(operations) });
const STACK = ['segment', 'detect_robots', 'detect_balls', 'count_balls', 'tell_balls', 'publish'];
const setStack = (stack, camera = 0) => service.patch({ op: 'replace', path: `/cameras/${camera}/stack`, value: stack });
const alertsOf = (status, id) => status.alerts.filter((alert) => alert.id === id);

describe('stage libraries', () => {
  before(() => {
    mkdirSync(folder);
    service.options = ['--stages', folder];
  });
  beforeEach(async () => {
    await service.stop();
    await service.forget();
    rmSync(folder, { recursive: true });
    mkdirSync(folder);
  });
  after(() => service.end());

  it('provide stages with parameters, parts of their own and times', async () => {
    put('counting');
    await service.start();
    const { properties } = await ask('api/schema');
    const camera = properties.cameras.items.properties;
    assert.ok(camera.stack.items.enum.includes('count_balls'));
    assert.deepEqual(camera.stages.properties.count_balls.properties.at_least.maximum, 100);

    await setStack(STACK);
    const { cameras } = await service.statusBecomes((status) => status.cameras[0].stages.length === STACK.length && status.cameras[0].stages[3].p50_us > 0);
    assert.deepEqual(cameras[0].stages.map(({ name }) => name), STACK);
    await service.patch({ op: 'replace', path: '/cameras/0/stages/count_balls/at_least', value: 7 });
    assert.equal((await patch({ op: 'replace', path: '/cameras/0/stages/count_balls/at_least', value: 101 })).status, 422);
    const metrics = await (await fetch(service.address('metrics'))).text();
    assert.match(metrics, /sslv_stage_duration_seconds_count\{camera="0",stage="count_balls"\} \d+/);
    assert.deepEqual(alertsOf(await ask('api/status'), 'stage_library'), []);
  });

  it('that are invalid are named and skipped, and the service runs', async () => {
    for (const name of ['counting', 'no_stamp', 'missing_symbol', 'throws_loading', 'crashes_loading', 'exits_loading', 'throws_making']) put(name);
    writeFileSync(join(folder, 'cut_off.so'), readFileSync(join(folder, 'counting.so')).subarray(0, 5000));
    await service.start();
    const status = await service.statusBecomes(({ cameras }) => cameras.every(({ state }) => state === 'running'));
    const titles = alertsOf(status, 'stage_library').map(({ title }) => title).sort();
    assert.deepEqual(titles.map((title) => /^The stage library .*\/(\w+)\.so is left out: it \S/.exec(title)?.[1]),
      ['crashes_loading', 'cut_off', 'exits_loading', 'missing_symbol', 'no_stamp', 'throws_loading', 'throws_making'], titles.join('\n'));
    for (const name of ['cut_off', 'no_stamp']) assert.equal(service.log().split('\n').filter((line) => line.includes(`${name}.so`)).length, 1, `one line for ${name}`);
    await setStack(STACK);
  });

  it('that are missing are reported and keep their settings, while the rest of the stack runs', async () => {
    put('counting');
    await service.start();
    await setStack(STACK);
    await service.patch({ op: 'replace', path: '/cameras/0/stages/count_balls/at_least', value: 3 });
    await service.stop();
    rmSync(join(folder, 'counting.so'));
    await service.start();
    const status = await service.statusBecomes(({ cameras }) => cameras.every(({ state, robots }) => state === 'running' && robots > 0));
    assert.deepEqual(status.cameras[0].stages.map(({ name }) => name), ['segment', 'detect_robots', 'detect_balls', 'publish']);
    const [alert, ...more] = alertsOf(status, 'stage_missing');
    assert.deepEqual(more, []);
    assert.equal(alert.title, "Camera 0 runs without the stages 'count_balls' and 'tell_balls', which are not installed");
    assert.equal(alert.camera, 0);
    assert.match(alert.fix, /No stage library provides them\. /);

    const { settings } = await ask('api/settings');
    assert.deepEqual(settings.cameras[0].stack, STACK);
    assert.equal(settings.cameras[0].stages.count_balls.at_least, 3);
    await service.patch({ op: 'replace', path: '/cameras/0/name', value: 'Other changes go on' });
    const refused = await patch({ op: 'replace', path: '/cameras/1/stack', value: ['segment', 'no_such_stage'] });
    assert.equal(refused.status, 422);
    assert.match(await refused.text(), /\/cameras\/1\/stack: the stage 'no_such_stage' is not installed/);

    await service.stop();
    put('counting');
    await service.start();
    const again = await service.statusBecomes(({ cameras }) => cameras[0].stages.length === STACK.length);
    assert.deepEqual(alertsOf(again, 'stage_missing'), []);
    assert.equal((await ask('api/settings')).settings.cameras[0].stages.count_balls.at_least, 3);
  });

  it('of another version, with other parameters, cost their own stage and no other setting', async () => {
    put('counting');
    await service.start();
    await setStack(['segment', 'detect_robots', 'detect_balls', 'count_balls', 'publish']);
    await service.patch({ op: 'replace', path: '/cameras/0/stages/count_balls/at_least', value: 3 });
    await service.patch({ op: 'replace', path: '/cameras/0/name', value: 'North' });
    await service.stop();
    rmSync(join(folder, 'counting.so'));
    put('other_params');
    await service.start();
    const status = await service.statusBecomes(({ cameras }) => cameras.every(({ state, robots }) => state === 'running' && robots > 0));
    const [{ title, fix }] = alertsOf(status, 'stage_missing');
    assert.match(title, /^Camera 0 runs without the stage 'count_balls', whose parameters are for another version \(\/cameras\/0\/stages\/count_balls\/at_least: /);
    assert.equal(fix, 'Correct the parameters, or remove the stage from the stack.');
    assert.equal((await ask('api/settings')).settings.cameras[0].name, 'North');
    await service.patch({ op: 'replace', path: '/cameras/0/stages/count_balls', value: { at_most: 2 } });
    const good = await service.statusBecomes(({ cameras }) => cameras[0].stages.length === 5);
    assert.deepEqual(alertsOf(good, 'stage_missing'), []);
  });

  it('run in a sandbox if untrusted, and may crash there', async () => {
    service.options = ['--stages-apart', folder];
    put('counting');
    await service.start();
    await setStack(STACK);
    const children = () => readdirSync('/proc').filter((pid) => {
      try {
        const [command] = readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0').slice(1);
        return command === '--stage-process' && readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ')[1] === String(service.pid());
      } catch {
        return false; // it has ended
      }
    });
    await becomes(async () => children(), (pids) => pids.length === 2);
    const runs = ({ cameras }) => cameras[0].stages.length === STACK.length && cameras[0].stages[3].p50_us > 0;
    const { cameras: [before] } = await service.statusBecomes(runs);
    // After the first kill the process may be back before the next image, if the computer is not busy.
    const killing = async () => {
      for (const pid of children()) {
        try {
          process.kill(Number(pid), 'SIGKILL');
        } catch {
          // it has ended
        }
      }
      return ask('api/status');
    };
    const isKilled = (now) => alertsOf(now, 'stage_warns').some(({ title }) => /killed by signal 9/.test(title));
    await becomes(killing, (now) => now.cameras[0].frames > before.frames + 5 && now.cameras[0].robots > 0 && isKilled(now));
    await becomes(async () => children(), (pids) => pids.length === 2);
    await service.patch({ op: 'replace', path: '/cameras/0/stages/count_balls/deadline_ms', value: 20 });
    assert.equal((await patch({ op: 'replace', path: '/cameras/0/stages/count_balls/at_least', value: 101 })).status, 422);
    const blocked = (pid) => {
      try {
        return /^SigBlk:\t(.*)$/m.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))?.[1];
      } catch {
        return 'it is gone';
      }
    };
    await becomes(async () => children().map(blocked), (masks) => masks.length === 2 && masks.every((mask) => mask === '0000000000000000'));
    const pids = children();
    await service.stop();
    assert.deepEqual(pids.filter((pid) => existsSync(`/proc/${pid}`)), [], 'none outlives the service');
    service.options = ['--stages', folder];
  });

  it('may print half a line before the service ends', async () => {
    service.options = ['--stages-apart', folder];
    put('starts_late');
    await service.start();
    await setStack(['segment', 'detect_robots', 'detect_balls', 'starts_late', 'publish']);
    await service.statusBecomes(({ cameras: [{ stages }] }) => /(^|; it says: )has printed$/.test(stages[3]?.note?.text));
    await service.stop();
    assert.match(service.log(), /stage 'starts_late': half a line$/m);
    service.options = ['--stages', folder];
  });

  it('are needed to check settings that use them', () => {
    const file = join(service.folder, 'checked.json');
    writeFileSync(file, JSON.stringify({ cameras: [{ stack: STACK }] }));
    const check = (...options) => spawnSync(DAEMON, ['--check-config', file, ...options], { encoding: 'utf8' });
    assert.equal(check().status, 78);
    assert.match(check('--stages', folder).stderr, /\/cameras\/0\/stack\/3: unknown stage 'count_balls'; known: /);
    put('counting');
    assert.equal(check('--stages', folder).status, 0);
  });
});
