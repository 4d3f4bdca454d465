// SPDX-License-Identifier: Apache-2.0
// The running service must match docs/openapi.json: the same routes, and answers as documented.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { becomes as looksUntil, createService, eventually, OF_THE_COMPUTER, root } from './service.mjs';

const require = createRequire(join(root, 'webui/package.json'));
const Ajv = require('ajv/dist/2020').default;

const service = await createService('239.255.77.79');
const openApi = JSON.parse(readFileSync(join(root, 'docs/openapi.json'), 'utf8'));
const ajv = new Ajv({ strict: true, strictTypes: false, allowUnionTypes: true });
for (const word of ['components', 'paths', 'openapi', 'info', 'servers', 'tags']) ajv.addKeyword(word);
ajv.addFormat('binary', true);
ajv.addSchema(openApi, 'openapi');

/** Follows a reference within the file. */
const resolve = (part) =>
  part.$ref ? part.$ref.slice(2).split('/').reduce((at, key) => at[key.replaceAll('~1', '/')], openApi) : part;
const escaped = (key) => key.replaceAll('~', '~0').replaceAll('/', '~1');
/** The path of a route's response within the file. */
const place = (path, method, status) => `openapi#/paths/${encodeURIComponent(escaped(path))}/${method}/responses/${status}`;

function checkJson(schemaPlace, value, what) {
  const isValid = ajv.validate({ $ref: schemaPlace }, value);
  assert.ok(isValid, `${what}: ${ajv.errorsText(ajv.errors, { separator: '\n' })}\n${JSON.stringify(value).slice(0, 2000)}`);
}

const seen = new Set();

/** Sends a request and checks that the answer's status, content type and shape are documented. */
async function ask(method, path, { parameters = {}, query = '', headers = {}, body, expect = 200 } = {}) {
  const operation = openApi.paths[path]?.[method];
  assert.ok(operation, `${method} ${path} is not documented`);
  const url = service.address(path.slice(1).replace(/\{(\w+)\}/g, (_, name) => encodeURIComponent(parameters[name] ?? 0))) + query;
  const answer = await fetch(url, {
    method: method.toUpperCase(), headers, body: body === undefined || typeof body === 'string' || Buffer.isBuffer(body) ? body : JSON.stringify(body),
  });
  const what = `${method.toUpperCase()} ${url}`;
  const bytes = Buffer.from(await answer.arrayBuffer());
  assert.equal(answer.status, expect, `${what}: ${bytes.toString().slice(0, 500)}`);
  seen.add(`${method} ${path} ${answer.status}`);
  seen.add(`${method} ${path}`);

  // A status that any route may return is described once, in the file's introduction.
  const documented = operation.responses[String(answer.status)];
  const reference = documented?.$ref ? `openapi${documented.$ref}` : place(path, method, answer.status);
  const response = documented ? resolve(documented) : resolve({ $ref: '#/components/responses/BadRequest' });
  if (!documented) assert.ok([401, 403, 404, 405, 411, 413, 414, 431, 400].includes(answer.status), `${what}: ${answer.status} is not documented`);
  const type = answer.headers.get('content-type').split(';')[0];
  assert.ok(response.content[type], `${what}: ${type} is not documented`);
  if (type !== 'application/json') return bytes;
  const value = JSON.parse(bytes);
  const schema = documented ? `${reference}/content/${escaped(type).replaceAll('~1', '~1')}/schema` : 'openapi#/components/schemas/Error';
  checkJson(schema, value, what);
  return value;
}

const becomes = (path, wanted, parameters) => looksUntil(() => ask('get', path, { parameters }), wanted);

describe('the interface as docs/openapi.json says', () => {
  before(async () => {
    await service.start();
    await service.statusBecomes((status) => status.cameras.every(({ frames }) => frames > 0));
  });
  after(() => service.end());

  it('is a valid description', () => {
    const { paths } = openApi;
    const ids = Object.values(paths).flatMap((methods) => Object.values(methods).map(({ operationId }) => operationId));
    assert.equal(new Set(ids).size, ids.length);
    for (const name of Object.keys(openApi.components.schemas)) ajv.compile({ $ref: `openapi#/components/schemas/${name}` });
  });

  it('is served as it lies in docs', async () => {
    assert.deepEqual(await ask('get', '/api/openapi.json'), openApi);
  });

  it('has the version of the service and of the newest release in the changelog', async () => {
    const { version } = await ask('get', '/api/status');
    assert.equal(openApi.info.version, version);
    assert.equal(/^## (\d\S+)/m.exec(readFileSync(join(root, 'CHANGELOG.md'), 'utf8'))[1], version);
  });

  it('reports its status', async () => {
    const status = await ask('get', '/api/status');
    assert.equal(status.cameras.length, 2);
    await ask('get', '/api/cameras');
    await ask('get', '/api/sources');
    const { interfaces } = await ask('get', '/api/network/interfaces');
    const lo = interfaces.find(({ name }) => name === 'lo');
    assert.deepEqual({ ...lo, multicast: false }, { name: 'lo', addresses: ['127.0.0.1'], is_up: true, has_link: true, is_loopback: true, multicast: false });
  });

  it('reports what teams receive and who listens on its computer', async () => {
    const { detections, geometry } = await becomes('/api/network/packets', (value) => value.detections.length === 2 && value.geometry && value.detections.some(({ packet }) => packet.detection.balls));
    assert.deepEqual(detections.map(({ camera, packet }) => [camera, packet.detection.camera_id]), [[0, 0], [1, 1]]);
    assert.equal(geometry.packet.geometry.field.field_length, service.settings.field?.field_length ?? 9000);
    const { group, port, memberships } = await ask('get', '/api/network/listeners');
    assert.deepEqual({ group, port }, { group: service.settings.network.vision.group, port: service.settings.network.vision.port });
    assert.deepEqual(memberships.map(({ interface: card }) => card), ['lo']);
  });

  it('reports what all cameras together see', async () => {
    const field = await becomes('/api/field', (value) => value.robots.length === 12 && value.balls.length > 0);
    assert.deepEqual(field.stages.map(({ name }) => name), ['gather', 'clocks', 'agreement', 'track', 'publish']);
    await becomes('/api/field/agreement', (value) => value.cameras.length === 2);
    assert.deepEqual(await ask('get', '/api/field/kicks'), { kicks: [] });
    const { numbers } = await ask('get', '/api/field/ball_model');
    assert.deepEqual(numbers.map(({ learnt }) => learnt), Array(6).fill(null));
    // Nobody has kicked the simulated ball yet.
    await ask('post', '/api/field/ball_model/accept', { expect: 409 });
  });

  it('reports alerts and whether a match may begin', async () => {
    const path = '/cameras/1/source';
    const failing = ({ go, checks }) => {
      const failed = checks.filter(({ state }) => state === 'fail').map(({ id }) => id);
      assert.equal(go, failed.length === 0);
      return failed.filter((id) => !OF_THE_COMPUTER.checks.includes(id)).join();
    };
    await becomes('/api/checks', (value) => failing(value) === '');
    await service.patch({ op: 'replace', path, value: { backend: 'files', path: join(service.folder, 'not-there') } });
    await becomes('/api/checks', (value) => failing(value) === 'cameras');
    const lost = async () => (await becomes('/api/alerts', ({ alerts }) => alerts.some(({ id }) => id === 'camera_lost'))).alerts.find(({ id }) => id === 'camera_lost');
    const first = await lost();
    assert.equal(first.camera, 1);
    assert.equal(first.page, '#/camera/1');
    assert.ok(first.since > 1.7e9);
    assert.equal((await lost()).since, first.since);
    const { cameras } = await becomes('/api/timeline', (value) => value.cameras[1]?.fps.at(-1) === null);
    assert.equal(cameras[0].id, 0);
    await service.patch({ op: 'replace', path, value: service.settings.cameras[1].source });
    await becomes('/api/checks', (value) => failing(value) === '');
  });

  it('refuses patches that grow without end', async () => {
    const doubling = [{ op: 'add', path: '/x', value: [] }, ...Array.from({ length: 22 }, () => ({ op: 'copy', from: '', path: '/x/-' }))];
    const nesting = [{ op: 'add', path: '/x', value: {} }, ...Array.from({ length: 1900 }, () => ({ op: 'copy', from: '/x', path: '/x/x' }))];
    const { revision } = await ask('get', '/api/settings');
    for (const [body, why] of [[doubling, /more values and bytes|nested deeper/], [nesting, /nested deeper than 64/]]) {
      for (const [method, path] of [['post', '/api/settings/check'], ['patch', '/api/settings']])
        assert.match((await ask(method, path, { body, expect: 422 })).error, why);
    }
    assert.equal((await ask('get', '/api/settings')).revision, revision);
  });

  it('reports which pixels a calibrated camera ignores', async () => {
    const hiddenPx = async () => (await ask('get', '/api/cameras/{camera}/field_view')).hidden.reduce((sum, [, , width, height]) => sum + width * height, 0);
    const path = '/cameras/0/mask/beyond_boundary';
    const usual = await hiddenPx();
    await service.patch({ op: 'replace', path, value: 100 });
    const less = await hiddenPx();
    assert.ok(less < usual && usual < 780 * 580 / 2, `${less} px after ${usual}`);
    await service.patch({ op: 'replace', path, value: null });
    assert.equal(await hiddenPx(), 0);
    const refused = await ask('patch', '/api/settings', { body: [{ op: 'replace', path, value: -1 }], expect: 422 });
    assert.match(refused.error, /\/cameras\/0\/mask\/beyond_boundary: -1 is not allowed/);
    await service.patch({ op: 'replace', path, value: 0 });
    assert.equal(await hiddenPx(), usual);
    await ask('get', '/api/cameras/{camera}/field_view', { parameters: { camera: 9 }, expect: 404 });
  });

  it('has metrics and health checks', async () => {
    assert.match((await ask('get', '/metrics')).toString(), /^# HELP sslv_build_info /);
    assert.equal((await ask('get', '/healthz')).toString(), 'ok\n');
    await looksUntil(async () => (await fetch(service.address('readyz'))).status, (status) => status === 200);
    assert.equal((await ask('get', '/readyz')).toString(), 'ok\n');
  });

  it('remembers the last seconds', async () => {
    const packets = await becomes('/api/network/timeline', (value) => value.packets_per_s.at(-1) > 0);
    assert.equal(packets.time_s.length, packets.packets_per_s.length);
    assert.equal((await ask('get', '/api/network/timeline', { query: '?seconds=1' })).time_s.length, 1);
    await ask('get', '/api/network/timeline', { query: '?seconds=0', expect: 400 });
    const path = '/api/timeline';
    const all = await becomes(path, (value) => value.cameras.every(({ fps }) => fps.filter((one) => one > 0).length > 2));
    for (const camera of all.cameras) {
      for (const [name, values] of Object.entries(camera)) if (name !== 'id') assert.equal(values.length, all.time_s.length, name);
    }
    assert.ok(all.time_s.every((time, i) => i === 0 || time > all.time_s[i - 1]));
    assert.equal((await ask('get', path, { query: '?seconds=2' })).time_s.length, 2);
    for (const seconds of ['0', '601', 'x']) await ask('get', path, { query: `?seconds=${seconds}`, expect: 400 });
  });

  it('reports the state of the computer and durations', async () => {
    const { system, cameras } = await becomes('/api/diagnostics', (value) => value.system.cpu_percent.length > 0
      && value.cameras.every(({ exposure, latency }) => exposure && latency.counts.reduce((sum, count) => sum + count, 0) > 10));
    assert.equal(system.disk.folder.startsWith('/'), true);
    assert.ok(system.process.threads > 5 && system.process.rss_bytes > 1e7);
    assert.equal(cameras.length, 2);
    for (const { latency, stages, exposure } of cameras) {
      assert.equal(latency.edges_us.length, latency.counts.length + 1);
      assert.ok(stages.some(({ name, histogram }) => name === 'segment' && histogram.counts.length > 0));
      assert.ok(exposure.mean_luma > 25 && exposure.clipped_share < 0.02);
    }
  });

  it('has a history of alerts and changes', async () => {
    await service.patch({ op: 'replace', path: '/site', value: 'Remembered' });
    const { kept_s: kept, entries } = await becomes('/api/events', (value) => value.entries.some(({ id, title }) => id === 'settings_changed' && title === 'Settings changed: /site'));
    assert.equal(kept, 24 * 3600);
    assert.ok(entries.some(({ id, kind, end }) => id === 'service_started' && kind === 'event' && end !== null));
    const alerts = openApi.components.schemas.AlertId.enum;
    assert.ok(entries.every(({ kind, id }) => (kind === 'alert') === alerts.includes(id)));
  });

  it('shows its log', async () => {
    const path = '/api/log';
    const all = await ask('get', path);
    assert.ok(all.lines.some(({ text, level }) => level === 'info' && text.startsWith('panel on port')));
    assert.equal(all.lines.at(-1).seq, all.next);
    await service.patch({ op: 'replace', path: '/site', value: 'Logged' });
    const fresh = await ask('get', path, { query: `?after=${all.next}&level=info` });
    assert.ok(fresh.lines.some(({ text }) => text.includes('Logged')));
    assert.ok(fresh.lines.every(({ seq }) => seq > all.next));
    const bad = await ask('get', path, { query: '?level=loud', expect: 400 });
    assert.match(bad.error, /level: "loud".*"warning"/);
    await ask('get', path, { query: '?after=-1', expect: 400 });
  });

  it('shows cameras', async () => {
    const path = '/api/cameras/{camera}/snapshot.jpg';
    assert.equal((await ask('get', path, { query: '?width=200&quality=50' })).readUInt16BE(0), 0xffd8);
    await ask('get', path, { query: '?picture=labels' });
    await ask('get', path, { query: '?width=0', expect: 400 });
    await ask('get', path, { query: '?picture=x', expect: 400 });
    await ask('get', path, { parameters: { camera: 9 }, expect: 404 });
  });

  it('edits, learns and follows colours', async () => {
    const colors = '/api/cameras/{camera}/colors';
    assert.equal((await ask('get', colors)).bits, 7);
    await ask('get', colors, { parameters: { camera: 9 }, expect: 404 });
    const paint = { op: 'paint', label: 'cyan', shape: 'ball', at: [90, 60, 60], radius: [9, 9, 9], over: 'clear' };
    assert.ok((await ask('post', `${colors}/edits`, { body: { commands: [paint], try: true } })).cells > 0);
    const { state } = await ask('post', `${colors}/edits`, { body: { commands: [paint, { op: 'grow', label: 'cyan' }, { op: 'smooth', label: 'cyan' }, { op: 'fill', label: 'black', at: [90, 60, 60], all_lumas: true }, { op: 'replace', from: 'black', to: 'cyan' }] } });
    assert.match(state.undo.what, /cyan/);
    await ask('post', `${colors}/edits`, { body: { commands: [{ op: 'dance' }] }, expect: 422 });
    const table = await ask('get', `${colors}/table`);
    assert.equal(table.toString('latin1', 0, 8), 'SSLVLUT2');
    await ask('get', `${colors}/table`, { query: '?light=maybe', expect: 400 });
    await ask('get', `${colors}/export`, { query: '?format=json' });
    await ask('post', `${colors}/undo`);
    await ask('post', `${colors}/redo`);
    await ask('post', `${colors}/redo`, { expect: 409 });
    await ask('post', `${colors}/reset`);
    await ask('post', `${colors}/copy`, { body: { from: 1 } });
    await ask('post', `${colors}/copy`, { body: { from: 0 }, expect: 409 });
    assert.equal((await ask('post', `${colors}/import`, { query: '?name=x.lut&try=true', body: table })).tables.length, 1);
    await ask('post', `${colors}/import`, { body: Buffer.from('nothing'), expect: 422 });
    await ask('post', `${colors}/light/revert`, { expect: 409 });
    await ask('post', `${colors}/light/keep`, { expect: 409 });

    const { still } = await ask('post', '/api/cameras/{camera}/stills', { expect: 201 });
    await ask('get', '/api/cameras/{camera}/stills/{still}/picture.jpg', { parameters: { still }, query: '?width=100' });
    await ask('get', '/api/cameras/{camera}/stills/{still}/labels', { parameters: { still } });
    await ask('get', '/api/cameras/{camera}/stills/{still}/labels', { parameters: { still: 99999 }, expect: 404 });
    assert.equal((await ask('get', '/api/cameras/{camera}/pixels', { query: `?x=10&y=10&width=6&height=4&still=${still}` })).count, 24);
    await ask('get', '/api/cameras/{camera}/pixels', { query: '?x=10&y=10&region=true' });
    await ask('get', '/api/cameras/{camera}/pixels', { query: '?x=a', expect: 400 });

    const learning = `${colors}/learning`;
    assert.equal((await ask('get', learning)).state, 'idle');
    await ask('delete', learning, { expect: 409 });
    await ask('post', learning, { body: { frames: 2, guide: [{ label: 'pink', x: 100, y: 100, still }] }, expect: 202 });
    await becomes(learning, ({ state: now }) => now === 'done');
    await ask('get', `${learning}/pictures/{picture}`, { parameters: { picture: 0 }, query: '?width=100' });
    await ask('get', `${learning}/pictures/{picture}`, { parameters: { picture: 1 }, query: '?labels=before' });
    await ask('post', `${learning}/reject`);
    await ask('post', `${learning}/accept`, { expect: 409 });
    await ask('post', learning, { body: { frames: 0 }, expect: 422 });
  });

  it('lists and previews sources of cameras', async () => {
    const jpeg = readFileSync(join(root, 'tests/golden/division_b.jpg'));
    const file = { source: { backend: 'files', path: join(root, 'tests/golden/division_b.jpg'), loop: true } };
    assert.equal((await ask('post', '/api/sources/image', { body: file, query: '?width=100' })).subarray(0, 2).toString('hex'), 'ffd8');
    await ask('post', '/api/sources/image', { body: {}, expect: 400 });
    await ask('post', '/api/sources/image', { body: { source: { backend: 'files', path: '/etc/shadow' } }, expect: 422 });

    await ask('get', '/api/files');
    await ask('get', '/api/files', { query: '?folder=/etc', expect: 422 });

    const { path } = await ask('post', '/api/images', { query: '?folder=hall&name=1.jpg', body: jpeg });
    await ask('post', '/api/images', { query: '?folder=hall&name=2.jpg', body: 'no image', expect: 422 });
    // The PNG header with the image size is not where it must be, so the memory that the image needs is unknown.
    const chunk = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0, 0, 0, 1, ...Buffer.from('tEXt'), 0, 0, 0, 0, 1, 0, 0, 0, 1]);
    await ask('post', '/api/images', { query: '?folder=hall&name=2.png', body: chunk, expect: 422 });
    const { folders } = await ask('get', '/api/images');
    assert.deepEqual(folders.map(({ name, images }) => ({ name, images })), [{ name: 'hall', images: 1 }]);
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: { backend: 'files', path, loop: true } });
    await ask('delete', '/api/images/{folder}', { parameters: { folder: 'hall' }, expect: 409 });
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: service.settings.cameras[1].source });
    await ask('delete', '/api/images/{folder}', { parameters: { folder: 'hall' } });
    await ask('delete', '/api/images/{folder}', { parameters: { folder: 'hall' }, expect: 404 });
  });

  it('sets the controls of a camera', async () => {
    const path = '/api/cameras/{camera}/controls/{control}';
    // A simulated camera has no controls; a recording has playback controls.
    await ask('get', '/api/cameras/{camera}/controls', { expect: 409 });
    await ask('post', path, { parameters: { control: 'speed' }, body: { value: 2 }, expect: 409 });
    const source = { backend: 'files', path: join(root, 'tests/golden/division_b.jpg'), loop: true, frame_rate_hz: 20 };
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: source });
    await service.statusBecomes(({ cameras }) => cameras[1].backend === 'files' && cameras[1].state === 'running');
    const parameters = { camera: 1, control: 'speed' };
    const { controls } = await ask('get', '/api/cameras/{camera}/controls', { parameters });
    assert.ok(controls.some(({ name }) => name === 'speed'));
    assert.equal((await ask('post', path, { parameters, body: { value: 2 } })).value, 2);
    await ask('post', path, { parameters, body: { value: -2 }, expect: 422 });
    await ask('post', path, { parameters, body: 'no JSON', expect: 400 });

    // A control that is set and not saved is reported and can be reset.
    const speed = async () => (await ask('get', '/api/cameras/{camera}/controls', { parameters })).controls.find(({ name }) => name === 'speed');
    assert.deepEqual([(await speed()).value, (await speed()).unsaved], [2, true]);
    const isTold = ({ alerts, cameras }) => cameras[1].controls_unsaved === 1 && alerts.some(({ id, camera }) => id === 'controls_unsaved' && camera === 1);
    await service.statusBecomes(isTold);
    const revert = '/api/cameras/{camera}/revert_controls';
    await ask('post', revert, { parameters, body: { names: [] }, expect: 400 });
    await ask('post', revert, { expect: 409 });
    await ask('post', revert, { parameters: { camera: 9 }, expect: 404 });
    await ask('post', revert, { parameters });
    assert.deepEqual([(await speed()).value, (await speed()).unsaved], [1, false]);
    await service.statusBecomes((now) => !isTold(now));

    // A dry run sets no control and triggers no action, even among many requests while real changes are made.
    const ofCamera = (wanted) => [{ op: 'replace', path: '/cameras/1/source/controls', value: wanted }];
    const tryOut = () => ask('post', '/api/settings/check', { body: ofCamera({ speed: 3, step: true, paused: true }) });
    await Promise.all([...Array(8)].map(tryOut));
    const player = async () => Object.fromEntries((await ask('get', '/api/cameras/{camera}/controls', { parameters })).controls.map(({ name, value }) => [name, value]));
    assert.deepEqual([(await player()).speed, (await player()).paused], [1, false]);
    for (const wanted of [{ speed: 4 }, { speed: 5, loop: true }, {}]) {
      const [{ refused }] = await Promise.all([ask('patch', '/api/settings', { body: ofCamera(wanted) }), tryOut(), tryOut()]);
      assert.deepEqual(refused, []);
      assert.deepEqual([(await player()).speed, (await player()).paused], [wanted.speed ?? 1, false]);
    }
    const { error } = await ask('post', '/api/settings/check', { body: ofCamera({ speed: -2 }), expect: 422 });
    assert.equal(error, '/cameras/1/source/controls/speed: -2 is not allowed; expected a number from 0.01 to 100');
    assert.equal((await ask('patch', '/api/settings', { body: ofCamera({ speed: -2 }), expect: 422 })).error, error);

    const reopen = '/api/cameras/{camera}/reopen';
    await ask('post', reopen, { parameters, expect: 409 });
    await ask('post', reopen, { parameters: { camera: 9 }, expect: 404 });
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: { ...source, path: join(root, 'tests/golden/no_such.jpg') } });
    await service.statusBecomes(({ cameras }) => cameras[1].state === 'lost');
    assert.equal((await ask('post', reopen, { parameters })).id, 1);
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: service.settings.cameras[1].source });
    await service.statusBecomes(({ cameras }) => cameras[1].backend === 'simulator' && cameras[1].state === 'running');
  });

  it('keeps settings', async () => {
    const before = await ask('get', '/api/settings');
    checkJson('openapi#/components/schemas/SettingsRevision', before);
    const schema = await ask('get', '/api/schema');
    assert.ok(schema.properties.cameras);
    const change = [{ op: 'replace', path: '/site', value: 'By the book' }];
    const { revision } = await ask('patch', '/api/settings', { body: change, headers: { 'If-Match': `"${before.revision}"` } });
    assert.equal(revision, before.revision + 1);
    const stale = await ask('patch', '/api/settings', { body: change, headers: { 'If-Match': `"${before.revision}"` }, expect: 409 });
    assert.equal(stale.revision, revision);
    assert.deepEqual(stale.changed_since.map(({ changes }) => changes), [[{ op: 'replace', path: '/site', before: before.settings.site, after: 'By the book' }]]);
    const [newest] = await ask('get', '/api/settings/history');
    assert.deepEqual({ revision: newest.revision, who: newest.who }, { revision, who: '127.0.0.1' });
    const undone = await ask('post', '/api/settings/undo', { body: { revision } });
    assert.equal(undone.settings.site, before.settings.site);
    await ask('post', '/api/settings/undo', { body: { revision }, expect: 409 });
    await ask('post', '/api/settings/undo', { body: { revision: 9999 }, expect: 422 });
    await ask('post', '/api/settings/undo', { body: { revision: 'x' }, expect: 400 });
    await ask('patch', '/api/settings', { body: [{ op: 'replace', path: '/site', value: 7 }], expect: 422 });
    await ask('patch', '/api/settings', { body: '[', expect: 400 });
    await ask('patch', '/api/settings', { body: `${'['.repeat(300_000)}`, expect: 400 });
    for (const patch of [{}, 7, null, 'x', [7], [{ op: 'replace' }], [{ op: 'replace', path: 'site', value: 7 }], [{ op: 'replace', path: '/nowhere/x', value: 7 }]]) {
      await ask('patch', '/api/settings', { body: JSON.stringify(patch), expect: 422 });
    }
    const presets = await ask('get', '/api/field/presets');
    assert.ok(presets.some(({ name }) => name === 'division-b'));
  });

  it('checks settings without changing them', async () => {
    const path = '/api/settings/check';
    const before = await ask('get', '/api/settings');
    const { changes } = await ask('post', path, { body: [{ op: 'replace', path: '/site', value: 'Elsewhere' }] });
    assert.deepEqual(changes, [{ op: 'replace', path: '/site', before: before.settings.site, after: 'Elsewhere' }]);
    assert.deepEqual(await ask('post', path, { body: [] }), { changes: [] });
    // The same message as from PATCH, also for errors that are found only when the change is prepared.
    for (const change of [
      { op: 'replace', path: '/site', value: 7 },
      { op: 'replace', path: '/nowhere/x', value: 7 },
      { op: 'replace', path: '/cameras/0/stack', value: ['publish', 'segment'] },
      { op: 'replace', path: '/cameras/0/colors/lut', value: '/no/such/file.lut' },
    ]) {
      const { error } = await ask('post', path, { body: [change], expect: 422 });
      assert.equal((await ask('patch', '/api/settings', { body: [change], expect: 422 })).error, error);
    }
    await ask('post', path, { body: '[', expect: 400 });
    assert.deepEqual(await ask('get', '/api/settings'), before);
  });

  it('keeps profiles', async () => {
    const path = '/api/profiles/{profile}';
    const night = { parameters: { profile: 'Nacht & Nebel 夜' } };
    assert.deepEqual(await ask('get', '/api/profiles'), { profiles: [] });
    await ask('get', path, { ...night, expect: 404 });
    const saved = await ask('put', path, night);
    assert.deepEqual({ name: saved.name, who: saved.who }, { name: 'Nacht & Nebel 夜', who: '127.0.0.1' });
    assert.deepEqual((await ask('get', '/api/profiles')).profiles, [saved]);
    const { settings, changes } = await ask('get', path, night);
    const before = await ask('get', '/api/settings');
    assert.deepEqual(settings, before.settings);
    assert.deepEqual(changes, []);
    assert.equal((await ask('post', `${path}/apply`, night)).revision, before.revision);  // nothing to change

    const { revision } = await ask('patch', '/api/settings', { body: [
      { op: 'replace', path: '/site', value: 'By day' },
      { op: 'replace', path: '/field/field_length', value: 10_000 },
    ] });
    assert.deepEqual((await ask('get', path, night)).changes.map((change) => change.path).sort(), ['/field/field_length', '/site']);
    await ask('post', `${path}/apply`, { ...night, headers: { 'If-Match': `${revision - 1}` }, expect: 409 });
    await ask('post', `${path}/apply`, { ...night, body: { paths: ['/feild'] }, expect: 422 });
    await ask('post', `${path}/apply`, { ...night, body: { paths: 'field' }, expect: 400 });
    const partly = await ask('post', `${path}/apply`, { ...night, body: { paths: ['/field'] } });
    assert.equal(partly.settings.site, 'By day');
    assert.equal(partly.settings.field.field_length, settings.field.field_length);
    const [newest] = await ask('get', '/api/settings/history');
    assert.equal(newest.what, 'profile Nacht & Nebel 夜');
    const wholly = await ask('post', `${path}/apply`, night);
    assert.deepEqual(wholly.settings, settings);
    assert.equal(wholly.revision, revision + 2);

    // A profile imported from another PC is validated; profiles survive a restart.
    const imported = { parameters: { profile: 'imported' } };
    await ask('put', path, { ...imported, body: { settings: { ...settings, site: 7 } }, expect: 422 });
    await ask('put', path, { ...imported, body: { setings: settings }, expect: 400 });
    await ask('put', path, { parameters: { profile: ' x' }, expect: 422 });
    await ask('put', path, { ...imported, body: { settings: { ...settings, site: 'Afar' } } });
    await service.stop();
    await service.start();
    const site = (await ask('get', path, imported)).changes.find((change) => change.path === '/site');
    assert.deepEqual(site, { op: 'replace', path: '/site', before: settings.site, after: 'Afar' });
    assert.deepEqual((await ask('delete', path, imported)).profiles, [saved]);
    await ask('delete', path, { ...imported, expect: 404 });
    await ask('post', `${path}/apply`, { ...imported, expect: 404 });
    await service.statusBecomes((status) => status.cameras.every(({ frames }) => frames > 0));
  });

  it('streams pictures', async () => {
    const path = '/api/cameras/{camera}/stream.mjpg';
    for (const query of ['?width=0', '?quality=x', '?fps=0', '?picture=x']) await ask('get', path, { query, expect: 400 });
    await ask('get', path, { parameters: { camera: 9 }, expect: 404 });
    const end = new AbortController();
    const answer = await fetch(service.address('api/cameras/0/stream.mjpg?width=100&fps=50'), { signal: end.signal });
    assert.equal(answer.status, 200);
    assert.ok(resolve({ $ref: '#/paths/~1api~1cameras~1{camera}~1stream.mjpg' }).get.responses[200].content[answer.headers.get('content-type').split(';')[0]]);
    let text = '';
    for await (const bytes of answer.body) {
      text += Buffer.from(bytes).toString('latin1');
      if (text.split('--ssl-visiond-picture\r\nContent-Type: image/jpeg\r\n').length > 4) break;
    }
    end.abort();
  });

  it('records match logs', async () => {
    const path = '/api/recordings/match-log';
    for (const body of [{}, { record: 1 }, { record: true, name: '../x' }, { record: true, more: 1 }, []]) await ask('post', path, { body, expect: 400 });
    await ask('post', path, { body: { record: false }, expect: 409 });
    const { match_log: { name } } = await ask('post', path, { body: { record: true, name: 'api' } });
    const parameters = { name };
    await ask('delete', '/api/recordings/logs/{name}', { parameters, expect: 409 });
    await ask('get', '/api/recordings/logs/{name}/events', { parameters, expect: 409 });
    await becomes('/api/recordings', ({ match_log: now }) => now.messages.vision > 10 && now.bytes > 100);
    await ask('post', path, { body: { record: false } });
    await becomes('/api/recordings', ({ logs: [log] }) => log.messages?.vision > 10);
    assert.equal((await ask('get', '/api/recordings/logs/{name}', { parameters })).subarray(0, 2).toString('hex'), '1f8b');
    const { begin_s, end_s } = await ask('get', '/api/recordings/logs/{name}/events', { parameters });
    assert.ok(end_s > begin_s);
    const time_s = end_s - begin_s;
    const moment = await ask('get', '/api/recordings/logs/{name}/at', { parameters, query: `?time_s=${time_s}` });
    assert.ok(moment.cameras.length > 0 && moment.cameras[0].time_s <= time_s);
    for (const query of ['', '?time_s=x', '?time_s=-1']) await ask('get', '/api/recordings/logs/{name}/at', { parameters, query, expect: 400 });
    await ask('patch', '/api/recordings/logs/{name}', { parameters, body: { pinned: 'x' }, expect: 400 });
    assert.equal((await ask('patch', '/api/recordings/logs/{name}', { parameters, body: { pinned: true } })).logs[0].pinned, true);
    assert.deepEqual((await ask('delete', '/api/recordings/logs/{name}', { parameters })).logs, []);
    for (const method of ['get', 'delete']) await ask(method, '/api/recordings/logs/{name}', { parameters, expect: 404 });
  });

  it('keeps, shows and compares clips', async () => {
    const path = '/api/recordings/clips', one = `${path}/{name}`;
    for (const body of [{ seconds: 0 }, { seconds_after: 601 }, { name: '../x' }, { more: 1 }, []]) await ask('post', path, { body, expect: 400 });
    await becomes(path, ({ last_seconds: { cameras } }) => cameras.length > 0 && cameras.every(({ frames }) => frames > 3));
    await ask('post', path, { body: { seconds: 600, name: 'api' }, expect: 202 });
    const { clips: [clip] } = await becomes(path, ({ clip: now, clips }) => now.state === 'idle' && typeof clips[0]?.seconds === 'number');
    const parameters = { name: clip.name };
    const { cameras } = await ask('get', `${one}/frames`, { parameters });
    const frame = cameras[0].places[1];
    assert.equal((await ask('get', `${one}/frames/{frame}`, { parameters: { ...parameters, frame } })).number, cameras[0].numbers[1]);
    await ask('get', `${one}/frames/{frame}`, { parameters: { ...parameters, frame: 1e6 }, expect: 404 });
    assert.equal((await ask('get', `${one}/frames/{frame}/picture`, { parameters: { ...parameters, frame }, query: '?width=100' })).toString('latin1', 6, 10), 'JFIF');
    for (const body of [{ camera: 99 }, { with: 'x' }, { more: 1 }]) await ask('post', `${one}/compare`, { parameters, body, expect: 400 });
    await ask('post', `${one}/compare`, { parameters, body: { with: 'learnt_colors' }, expect: 409 });
    await ask('post', `${one}/compare`, { parameters, body: {}, expect: 202 });
    const { result } = await becomes('/api/recordings/compare', ({ state }) => state === 'done');
    assert.equal(result.frames_that_differ, 0);
    await ask('patch', one, { parameters, body: { pinned: 1 }, expect: 400 });
    assert.equal((await ask('patch', one, { parameters, body: { pinned: true } })).clips[0].pinned, true);
    assert.equal((await ask('get', one, { parameters })).length, clip.bytes);
    assert.deepEqual((await ask('delete', one, { parameters })).clips, []);
    for (const method of ['get', 'delete']) await ask(method, one, { parameters, expect: 404 });
    for (const more of ['frames', 'frames/{frame}', 'frames/{frame}/picture']) await ask('get', `${one}/${more}`, { parameters, expect: 404 });
    await ask('post', `${one}/compare`, { parameters, body: {}, expect: 404 });
  });

  it('backs up and restores', async () => {
    const backup = await ask('get', '/api/backup');
    const { revision, changes, site } = await ask('post', '/api/backup/check', { body: backup });
    assert.deepEqual([changes, site], [[], (await ask('get', '/api/settings')).settings.site]);
    await ask('post', '/api/backup/restore', { body: backup, headers: { 'If-Match': String(revision + 1) }, expect: 409 });
    assert.equal((await ask('post', '/api/backup/restore', { body: backup, headers: { 'If-Match': String(revision) } })).passwords, 'none');
    for (const path of ['/api/backup/check', '/api/backup/restore']) await ask('post', path, { body: '{}', expect: 422 });
    await ask('get', '/api/backup', { query: '?passwords=x', expect: 400 });
  });

  it('packs a support bundle', async () => {
    const bundle = join(service.folder, 'bundle.tar.gz');
    writeFileSync(bundle, await ask('get', '/api/support'));
    execFileSync('tar', ['-xzf', bundle, '--strip-components=1'], { cwd: service.folder });
    const read = (name) => readFileSync(join(service.folder, name));
    assert.match(read('version.txt').toString(), /^\d+\.\d+/);
    checkJson('openapi#/components/schemas/Status', JSON.parse(read('status.json')), 'status.json');
    checkJson('openapi#/components/schemas/SettingsRevision', JSON.parse(read('settings.json')), 'settings.json');
    checkJson('openapi#/components/schemas/Timeline', JSON.parse(read('timeline.json')), 'timeline.json');
    checkJson('openapi#/components/schemas/Diagnostics', JSON.parse(read('diagnostics.json')), 'diagnostics.json');
    assert.match(read('log.txt').toString(), /^\d{4}-\d\d-\d\dT[\d:]{8}\.\d{3}Z info    .*panel on port \d+$/m);
    for (const id of [0, 1]) {
      checkJson('openapi#/components/schemas/CalibrationState', JSON.parse(read(`camera_${id}/calibration.json`)), 'calibration.json');
      assert.equal(read(`camera_${id}/picture.jpg`).readUInt16BE(0), 0xffd8);
      assert.deepEqual(read(`camera_${id}/colors.lut`), await ask('get', '/api/cameras/{camera}/colors/table', { parameters: { camera: id } }));
    }
    await ask('get', '/api/support', { query: '?clip=none.clip', expect: 404 });
    // The README lists every file in the bundle, and no other.
    const packed = execFileSync('tar', ['-tzf', bundle]).toString().trim().split('\n').map((name) => name.slice(name.indexOf('/') + 1));
    const named = [...read('README.txt').toString().matchAll(/^([\w/]+\.\w+): /gm)].map(([, name]) => name);
    assert.deepEqual(packed.sort(), ['README.txt', ...named].sort());
  });

  it('calibrates a camera', async () => {
    const path = '/api/cameras/{camera}/calibration';
    const { state } = await ask('get', path);
    assert.equal(state, 'idle');
    await ask('get', path, { parameters: { camera: 9 }, expect: 404 });
    for (const what of ['accept', 'reject', 'revert']) await ask('post', `${path}/${what}`, { expect: 409 });
    await ask('delete', path, { expect: 409 });
    await ask('post', path, { body: { points: 'none' }, expect: 422 });
    await ask('post', path, { body: '{', expect: 400 });
    await ask('post', path, { body: { frames: 1, height_mm: 4000 }, expect: 202 });
    const done = await becomes(path, (value) => !['collecting', 'solving'].includes(value.state));
    assert.equal(done.state, 'done', done.problem);
    await ask('post', `${path}/accept`, { body: { force: true } });
    await ask('post', `${path}/revert`, { body: { force: true } });
    await ask('post', path, { body: { frames: 1, height_mm: 4000 }, expect: 202 });
    await becomes(path, (value) => value.state === 'done');
    await ask('post', `${path}/reject`);
    // At this rate the calibration does not finish before the next request.
    await service.patch({ op: 'replace', path: '/cameras/0/source/frame_rate_hz', value: 1 });
    await ask('post', path, { body: { frames: 100 }, expect: 202 });
    await ask('post', path, { body: {}, expect: 409 });
    await ask('delete', path);
    await service.patch({ op: 'replace', path: '/cameras/0/source', value: service.settings.cameras[0].source });
  });

  it('calibrates several cameras together', async () => {
    const path = '/api/calibration';
    await ask('get', path);
    await ask('delete', path, { expect: 409 });
    for (const what of ['accept', 'reject']) await ask('post', `${path}/${what}`, { expect: 409 });
    await ask('post', path, { body: { cameras: [0, 9] }, expect: 422 });
    const request = { frames: 1, seconds: 1 };
    await ask('post', path, { body: request, expect: 202 });
    await becomes(path, ({ state }) => state === 'done');
    await ask('post', `${path}/accept`, { body: { force: true } });
    await ask('post', path, { body: request, expect: 202 });
    await becomes(path, ({ state }) => state === 'done');
    await ask('post', `${path}/reject`);
    await ask('post', path, { body: { frames: 1, seconds: 600 }, expect: 202 });
    await ask('post', path, { body: request, expect: 409 });
    await ask('delete', path);
  });

  it('refuses unknown resources', async () => {
    await ask('get', '/api/ws', { expect: 426 });
    const answer = await fetch(service.address('api/nothing'));
    assert.equal(answer.status, 404);
    checkJson('openapi#/components/schemas/Error', await answer.json(), 'an unknown route');
    const wrong = await fetch(service.address('api/status'), { method: 'DELETE' });
    assert.equal(wrong.status, 405);
    assert.equal(wrong.headers.get('allow'), 'GET');
    checkJson('openapi#/components/schemas/Error', await wrong.json(), 'a wrong method');
  });

  it('reports access rights', async () => {
    const path = '/api/session', password = 'correct horse';
    assert.equal((await ask('get', path)).may, 'change');
    await ask('post', path, { body: { password }, expect: 409 });
    await ask('post', path, { body: { word: password }, expect: 422 });
    await ask('post', '/api/match_lock', { body: { opened: true }, expect: 409 });
    const passwords = '/api/passwords/{role}';
    await ask('put', passwords, { parameters: { role: 'king' }, body: { password }, expect: 404 });
    await ask('put', passwords, { parameters: { role: 'admin' }, body: { password: 'short' }, expect: 422 });
    await ask('put', passwords, { parameters: { role: 'admin' }, body: { password } });
    await service.opensToOthers();
    assert.equal((await ask('get', path)).may, 'look');
    assert.equal((await ask('post', path, { body: { password } })).may, 'change');
    assert.equal((await ask('delete', path)).may, 'look');
    // All at once, as one attempt becomes available every ten seconds; a correct one may be among the first.
    const seen = new Set();
    await eventually(async () => {
      const wrong = Array.from({ length: 20 }, () => fetch(service.address('api/session'), { method: 'POST', body: '{"password":"wrong horse"}' }));
      const statuses = Promise.all(wrong.map(async (answer) => (await answer).status));
      try {
        await ask('post', path, { body: { password }, expect: 429 });
      } finally {
        for (const status of await statuses) seen.add(status);
      }
    });
    assert.deepEqual([...seen].sort(), [401, 429]);
    await ask('put', passwords, { parameters: { role: 'admin' }, body: { password }, expect: 401 });
    await ask('patch', '/api/settings', { body: [], expect: 401 });
  });

  it('was tested completely', () => {
    for (const [path, methods] of Object.entries(openApi.paths)) {
      for (const method of Object.keys(methods)) assert.ok(seen.has(`${method} ${path}`), `${method} ${path} was not asked`);
    }
  });
});
