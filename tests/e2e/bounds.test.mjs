// SPDX-License-Identifier: Apache-2.0
// Limits: settings have a maximum size, as do patches while they are applied, and memory is released afterwards.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { readFileSync, writeFileSync } from 'node:fs';
import { after, before, describe, it } from 'node:test';
import { FORGED } from '../strangers/attacks/backups.mjs';
import { Random } from '../strangers/random.mjs';
import { becomes, createService, freeUdpPort } from './service.mjs';

const service = await createService('239.255.77.121');
service.settings.recording.last_seconds.memory_mb = 0; // allocated some seconds after the start; these tests check that memory does not grow
after(() => service.end());

async function ask(method, path, body) {
  const answer = await fetch(service.address(path), { method, body: body === undefined ? undefined : JSON.stringify(body) });
  return { status: answer.status, json: await answer.json() };
}
const settings = async () => (await ask('GET', 'api/settings')).json;
const replace = (path, value) => [{ op: 'replace', path, value }];
const points = (count) => Array.from({ length: count }, (_, i) => [i % 100, Math.floor(i / 100)]);
const polygons = (count, corners = 3) => Array.from({ length: count }, () => ({ points: points(corners) }));

describe('settings', () => {
  before(() => service.restore());

  const simulator = (more) => ({ ...service.settings.cameras[0].source, ...more });
  const tooMuch = [
    ['/site', () => 'S'.repeat(900_000), /^\/site: "S{40,}\.\.\. is not allowed; expected a text of at most 200 characters$/],
    ['/cameras/0/name', () => 'ö'.repeat(201), /^\/cameras\/0\/name: "ö+\.\.\. is not allowed; expected a text of at most 200 characters$/],
    ['/patterns_file', () => 'f'.repeat(4096), /^\/patterns_file: "f+\.\.\. is not allowed; expected a text of at most 4095 characters$/],
    ['/panel/names', () => Array.from({ length: 33 }, (_, i) => `name${i}`), /^\/panel\/names: 33 entries are not allowed; expected at most 32$/],
    ['/panel/names', () => ['n'.repeat(201)], /^\/panel\/names\/0: "n+\.\.\. is not allowed; expected a name of at most 200 characters$/],
    ['/cameras/0/mask/include', () => [{ points: points(60_000) }], /^\/cameras\/0\/mask\/include\/0\/points: 60000 entries are not allowed; expected at most 200$/],
    ['/cameras/0/mask/exclude', () => polygons(20_000), /^\/cameras\/0\/mask\/exclude: 20000 entries are not allowed; expected at most 32$/],
    ['/cameras/0/mask/exclude', () => polygons(32, 32), /^\/cameras\/0\/mask: 1024 points in all polygons are not allowed; expected at most 1000$/],
    ['/cameras/0/stack', () => Array(65).fill('segment'), /^\/cameras\/0\/stack: 65 entries are not allowed; expected at most 64$/],
    ['/cameras/0/colors/classes', () => Array(257).fill({ label: 'field' }), /^\/cameras\/0\/colors\/classes: 257 entries are not allowed; expected at most 256$/],
    ['/cameras/0/source', () => simulator({ width: 16384, height: 16384 }), /^\/cameras\/0\/source: width 16384 and height 16384 are not allowed; expected at most 25000000 pixels$/],
    ['/cameras/0/source', () => simulator({ light_swing: points(1001) }), /^\/cameras\/0\/source\/light_swing: 1001 entries are not allowed; expected at most 1000$/],
    ['/cameras/0/source', () => ({ backend: 'b'.repeat(50_000) }), /^\/cameras\/0\/source\/backend: no capture backend "b+\.\.\."; known: /],
    ['/cameras/0/source', () => ({ backend: 'v4l2', controls: { gain: 'x'.repeat(200_000) } }), /^\/cameras\/0\/source: the object is too large; expected at most 100000 values and bytes of text in it$/],
    ['/cameras/0/stages', () => ({ ['s'.repeat(50_000)]: {} }), /^\/cameras\/0\/stages\/s+\.\.\.: unknown stage 's+\.\.\.'; known: /],
    ['/cameras', () => Array.from({ length: 33 }, (_, id) => ({ id })), /^\/cameras: 33 entries are not allowed; expected at most 32$/],
    ['/cameras', () => Array.from({ length: 5 }, (_, id) => ({ id, source: { backend: 'simulator', width: 5000, height: 5000 } })), /^\/cameras\/4\/source: simulated cameras of 125000000 pixels together are not allowed; expected at most 100000000$/],
  ];
  for (const [path, value, why] of tooMuch) {
    it(`refuse ${path} beyond its limit, and name the limit: ${String(why).slice(2, 60)}...`, async () => {
      const { revision } = await settings();
      for (const [method, route] of [['POST', 'api/settings/check'], ['PATCH', 'api/settings']]) {
        const { status, json } = await ask(method, route, replace(path, value()));
        assert.equal(status, 422, JSON.stringify(json).slice(0, 300));
        assert.match(json.error, why);
        assert.ok(json.error.length < 1000, `${json.error.length} characters`);
      }
      assert.equal((await settings()).revision, revision);
    });
  }

  it('have their limits in the schema', async () => {
    const missing = [];
    const look = (schema, path) => {
      for (const type of [schema.type].flat()) {
        if (type === 'string' && !schema.enum && schema.maxLength === undefined) missing.push(path);
        if (type === 'array' && schema.maxItems === undefined) missing.push(path);
      }
      if (schema.items) look(schema.items, `${path}/*`);
      for (const one of schema.oneOf ?? []) look(one, `${path}(${one.title})`);
      for (const [key, one] of Object.entries(schema.properties ?? {})) look(one, `${path}/${key}`);
    };
    look((await ask('GET', 'api/schema')).json, '');
    assert.deepEqual(missing, []);
  });

  const skip = process.env.SSLV_SANITIZE ? 'the sanitizer has its own allocator' : false;
  const rss_MB = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${service.pid()}/status`, 'utf8'))[1]) / 1024;
  const undo = async (revision) => {
    const { status, json } = await ask('POST', 'api/settings/undo', { revision });
    assert.equal(status, 200, JSON.stringify(json).slice(0, 300));
  };

  it('free the memory of large images and masks that are reverted', { skip }, async () => {
    const width = 2000;
    const [{ calibration }] = service.settings.cameras;
    const scale = width / calibration.pixel_image_width;
    const large = [
      ...replace('/cameras/0/source', simulator({ width, height: width, frame_rate_hz: 60 })),
      ...replace('/cameras/0/calibration', {
        ...calibration, focal_length: scale * calibration.focal_length, pixel_image_width: width, pixel_image_height: width,
        principal_point_x: scale * calibration.principal_point_x, principal_point_y: scale * calibration.principal_point_y,
      }),
      ...replace('/cameras/0/mask/exclude', polygons(32, 31)),
      ...replace('/site', 'S'.repeat(200)),
    ];
    // Twenty frames fill its frame ring.
    const runs = async (wanted) => {
      const { cameras: [{ frames }] } = await service.statusBecomes(({ cameras: [one] }) => one.state === 'running' && one.width === wanted);
      await service.statusBecomes(({ cameras: [one] }) => one.frames > frames + 20);
    };
    await runs(780);
    const before_MB = rss_MB();
    const { status, json } = await ask('PATCH', 'api/settings', large);
    assert.equal(status, 200, JSON.stringify(json).slice(0, 300));
    await runs(width);
    const large_MB = await becomes(rss_MB, (now_MB) => now_MB > before_MB + 50, (now_MB) => `${before_MB} MB, then ${now_MB}: was it large at all?`);
    await undo(json.revision);
    await runs(780);
    await becomes(rss_MB, (now_MB) => now_MB < before_MB + 25, (now_MB) => `${before_MB} MB, ${large_MB} MB, now ${now_MB} MB`);
  });

  it('free the memory of refused requests', { skip }, async () => {
    const before_MB = rss_MB();
    const patches = [replace('/site', 'S'.repeat(900_000)), replace('/cameras/0/mask/exclude', [{ points: points(60_000) }]), replace('/cameras/0/mask/exclude', polygons(20_000))];
    // The patches' text alone is much larger in total than the memory that may stay allocated.
    let sent = 0;
    while (sent < 75e6) {
      const tries = Array.from({ length: 24 }, (_, i) => patches[i % patches.length]);
      for (const { status } of await Promise.all(tries.map((patch) => ask('PATCH', 'api/settings', patch)))) assert.equal(status, 422);
      sent += tries.reduce((sum, patch) => sum + JSON.stringify(patch).length, 0);
    }
    await becomes(rss_MB, (now_MB) => now_MB < before_MB + 25, (now_MB) => `${before_MB} MB, now ${now_MB} MB`);
  });
});

describe('a body', () => {
  before(() => service.restore());

  const MOST_MB = 64, REFUSED = [400, 422];
  const skip = process.env.SSLV_SANITIZE ? 'the sanitizer has its own allocator' : false;
  const memory_MB = (what) => Number(new RegExp(`${what}:\\s+(\\d+)`).exec(readFileSync(`/proc/${service.pid()}/status`, 'utf8'))[1]) / 1024;
  /** By how many MB the service's peak memory exceeds its memory before the request. */
  async function grows_MB(path, body, wanted) {
    writeFileSync(`/proc/${service.pid()}/clear_refs`, '5'); // resets the peak to the current memory
    const before_MB = memory_MB('VmRSS');
    const answer = await fetch(service.address(path), { method: 'POST', body });
    assert.ok(wanted.includes(answer.status), `${answer.status}: ${(await answer.text()).slice(0, 300)}`);
    return memory_MB('VmHWM') - before_MB;
  }
  /** One small result in four tries is enough: other work of the service also allocates memory briefly. */
  async function isSmall(path, body, wanted, what) {
    const all_MB = [];
    while (!all_MB.some((grown_MB) => grown_MB <= MOST_MB)) {
      assert.ok(all_MB.length < 4, `${what}: ${all_MB.map((grown_MB) => grown_MB.toFixed(0)).join(', ')} MB`);
      all_MB.push(await grows_MB(path, body, wanted));
    }
  }

  it('uses little memory for any forged backup', { skip }, async () => {
    const random = new Random(1);
    for (const [what, make] of Object.entries(FORGED)) await isSmall('api/backup/check', make(random), [422], what);
  });

  it('uses little memory for any JSON', { skip }, async () => {
    const filled = (part, more = '') => `[${part.repeat(Math.floor(1_000_000 / part.length))}0]${more}`;
    for (const part of ['0,', '[],', '{},', '"",', '{"":0},', '[[[]]],']) {
      await isSmall('api/settings/check', filled(part), REFUSED, `a list of ${part}`);
      await isSmall('api/settings/check', `[{"op":"add","path":"/site","value":${filled(part)}}]`, REFUSED, `a value of ${part}`);
      await isSmall('api/cameras/0/colors/edits', `{"commands":${filled(part)}}`, REFUSED, `commands of ${part}`);
    }
    const table = Buffer.concat([Buffer.from('SSLVLUT2'), Buffer.from([8, 1, 2, 0, 2, 0x80, 0x80, 0x80, 0x08])]);
    await isSmall('api/cameras/0/colors/import?try=true&name=large.lut', table, [200], 'a colour table of few bytes');
  });
});

describe('a patch', () => {
  const group = '224.5.23.121';
  let socket, timer;
  before(async () => {
    await service.stop();
    const port = await freeUdpPort();
    service.settings.network.referee = { enabled: true, group, port, interface: 'lo' };
    service.settings.panel = { port: 0 };
    await service.start();
    socket = createSocket('udp4').bind(0, '127.0.0.1');
    await once(socket, 'listening');
    socket.setMulticastInterface('127.0.0.1');
    const running = Buffer.from([0x10, 1, 0x20, 2, 0x3a, 2, 0x0a, 0, 0x42, 2, 0x0a, 0]); // stage, command, both teams
    timer = setInterval(() => socket.send(running, port, group), 50);
  });
  after(() => {
    clearInterval(timer);
    socket.close();
  });

  const bombs = [
    ['that doubles', [{ op: 'add', path: '/x', value: [] }, ...Array.from({ length: 22 }, () => ({ op: 'copy', from: '', path: '/x/-' }))], /more values and bytes|nested deeper/],
    ['that nests', [{ op: 'add', path: '/x', value: {} }, ...Array.from({ length: 1900 }, () => ({ op: 'copy', from: '/x', path: '/x/x' }))], /nested deeper than 64/],
    ['of many operations', Array.from({ length: 20_001 }, () => ({ op: 'test', path: '', value: 0 })), /more operations than 20000/],
    ['that moves much', [{ op: 'add', path: '/x', value: Array(100_000).fill(1) }, ...Array.from({ length: 10_000 }, () => ({ op: 'move', from: '/x', path: '/x' }))], /more work than/],
    ['with a long text in it', [{ op: 'replace', path: `/${'p'.repeat(500_000)}`, value: 0 }], /not a JSON Patch that fits/],
  ];
  const refuses = async (ways) => {
    for (const [what, patch, why] of bombs) {
      for (const [method, path] of ways) {
        const { status, json } = await ask(method, path, patch);
        assert.equal(status, 422, `${what}: ${JSON.stringify(json).slice(0, 300)}`);
        assert.match(json.error, why);
        assert.ok(json.error.length < 1000, `${json.error.length} characters`);
      }
    }
  };
  const CHECK = ['POST', 'api/settings/check'];

  it('that grows without end is refused while a match runs', async () => {
    await becomes(() => ask('GET', 'api/session'), ({ json }) => json.match_lock.locked);
    await refuses([CHECK]);
  });

  it('that needs much work blocks neither readers nor editors', async () => {
    await becomes(() => ask('GET', 'api/session'), ({ json }) => json.match_lock.locked);
    assert.equal((await ask('POST', 'api/match_lock', { opened: true })).status, 200);
    await refuses([CHECK, ['PATCH', 'api/settings']]);
    const { revision } = await settings();
    const heavy = [{ op: 'add', path: '/x', value: Array(120_000).fill(1) }, ...Array.from({ length: 60 }, () => ({ op: 'copy', from: '/x', path: '/y' }))];
    let reads = 0;
    // On a busy computer, chance decides how many requests run at the same time, so repeat until some do.
    await becomes(async () => {
      let heavyDone = 0, meanwhile = 0;
      const all = [CHECK, ['PATCH', 'api/settings']].map(async ([method, path]) => {
        const { status, json } = await ask(method, path, heavy);
        assert.equal(status, 422, JSON.stringify(json).slice(0, 300));
        heavyDone++;
      });
      while (heavyDone === 0) {
        assert.equal((await settings()).revision, revision + reads);
        assert.equal((await ask('PATCH', 'api/settings', replace('/site', `Site ${reads}`))).status, 200);
        reads++;
        if (heavyDone === 0) meanwhile++;
      }
      await Promise.all(all);
      return meanwhile;
    }, (meanwhile) => meanwhile >= 2, (meanwhile) => `${meanwhile} reads and edits went on meanwhile`);
  });

  it('with too many keys in an object is refused', async () => {
    const wide = Object.fromEntries(Array.from({ length: 60_000 }, (_, i) => [`k${i}`, 0]));
    for (const [method, path] of [CHECK, ['PATCH', 'api/settings'], ['POST', 'api/session']]) {
      const { status, json } = await ask(method, path, wide);
      assert.equal(status, 400);
      assert.match(json.error, /more than 1000 keys in an object/);
    }
  });
});
