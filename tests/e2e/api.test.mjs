// SPDX-License-Identifier: Apache-2.0
// docs/openapi.json is the truth: the running service has these routes, and answers as it says.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { createService, root } from './service.mjs';

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
/** Where in the file a route's answer is. */
const place = (path, method, status) => `openapi#/paths/${encodeURIComponent(escaped(path))}/${method}/responses/${status}`;

function checkJson(schemaPlace, value, what) {
  const isValid = ajv.validate({ $ref: schemaPlace }, value);
  assert.ok(isValid, `${what}: ${ajv.errorsText(ajv.errors, { separator: '\n' })}\n${JSON.stringify(value).slice(0, 2000)}`);
}

const seen = new Set();

/** Asks a route and checks that status, kind and shape of the answer are documented. */
async function ask(method, path, { parameters = {}, query = '', headers = {}, body, expect = 200 } = {}) {
  const operation = openApi.paths[path]?.[method];
  assert.ok(operation, `${method} ${path} is not documented`);
  const url = service.address(path.slice(1).replace(/\{(\w+)\}/g, (_, name) => encodeURIComponent(parameters[name] ?? 0))) + query;
  const answer = await fetch(url, {
    method: method.toUpperCase(), headers, body: body === undefined ? undefined : typeof body === 'string' ? body : JSON.stringify(body),
  });
  const what = `${method.toUpperCase()} ${url}`;
  const bytes = Buffer.from(await answer.arrayBuffer());
  assert.equal(answer.status, expect, `${what}: ${bytes.toString().slice(0, 500)}`);
  seen.add(`${method} ${path} ${answer.status}`);
  seen.add(`${method} ${path}`);

  // A status that any route may answer with is described once, in the file's introduction.
  const documented = operation.responses[String(answer.status)];
  const reference = documented?.$ref ? `openapi${documented.$ref}` : place(path, method, answer.status);
  const response = documented ? resolve(documented) : resolve({ $ref: '#/components/responses/BadRequest' });
  if (!documented) assert.ok([403, 404, 405, 411, 413, 414, 431, 400].includes(answer.status), `${what}: ${answer.status} is not documented`);
  const type = answer.headers.get('content-type').split(';')[0];
  assert.ok(response.content[type], `${what}: ${type} is not documented`);
  if (type !== 'application/json') return bytes;
  const value = JSON.parse(bytes);
  const schema = documented ? `${reference}/content/${escaped(type).replaceAll('~1', '~1')}/schema` : 'openapi#/components/schemas/Error';
  checkJson(schema, value, what);
  return value;
}

async function becomes(path, wanted, parameters) {
  const deadline = Date.now() + 60_000;
  for (;;) {
    const value = await ask('get', path, { parameters });
    if (wanted(value)) return value;
    assert.ok(Date.now() < deadline, `${path} does not become as wanted: ${JSON.stringify(value).slice(0, 1000)}`);
  }
}

describe('the interface as docs/openapi.json says', () => {
  before(async () => {
    await service.start();
    await service.statusBecomes((status) => status.cameras.every(({ frames }) => frames > 0));
  });
  after(() => service.end());

  it('is a sound description', () => {
    const { paths } = openApi;
    const ids = Object.values(paths).flatMap((methods) => Object.values(methods).map(({ operationId }) => operationId));
    assert.equal(new Set(ids).size, ids.length);
    for (const name of Object.keys(openApi.components.schemas)) ajv.compile({ $ref: `openapi#/components/schemas/${name}` });
  });

  it('is served as it lies in docs', async () => {
    assert.deepEqual(await ask('get', '/api/openapi.json'), openApi);
  });

  it('tells how it is', async () => {
    const status = await ask('get', '/api/status');
    assert.equal(status.cameras.length, 2);
    await ask('get', '/api/cameras');
    await ask('get', '/api/sources');
    const { interfaces } = await ask('get', '/api/network/interfaces');
    const lo = interfaces.find(({ name }) => name === 'lo');
    assert.deepEqual({ ...lo, multicast: false }, { name: 'lo', addresses: ['127.0.0.1'], is_up: true, is_loopback: true, multicast: false });
  });

  it('shows cameras', async () => {
    const path = '/api/cameras/{camera}/snapshot.jpg';
    assert.equal((await ask('get', path, { query: '?width=200&quality=50' })).readUInt16BE(0), 0xffd8);
    await ask('get', path, { query: '?picture=labels' });
    await ask('get', path, { query: '?width=0', expect: 400 });
    await ask('get', path, { query: '?picture=x', expect: 400 });
    await ask('get', path, { parameters: { camera: 9 }, expect: 404 });
    await ask('get', '/api/cameras/{camera}/lut');
    await ask('get', '/api/cameras/{camera}/lut', { parameters: { camera: 9 }, expect: 404 });
  });

  it('sets what a camera offers', async () => {
    const path = '/api/cameras/{camera}/controls/{control}';
    // A simulated camera offers nothing; a recording is a player.
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
    const presets = await ask('get', '/api/field/presets');
    assert.ok(presets.some(({ name }) => name === 'division-b'));
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
    await ask('post', path, { body: {}, expect: 409 });
    const done = await becomes(path, (value) => !['collecting', 'solving'].includes(value.state));
    assert.equal(done.state, 'done', done.problem);
    await ask('post', `${path}/accept`, { body: { force: true } });
    await ask('post', `${path}/revert`, { body: { force: true } });
    await ask('post', path, { body: { frames: 1, height_mm: 4000 }, expect: 202 });
    await becomes(path, (value) => value.state === 'done');
    await ask('post', `${path}/reject`);
    await ask('post', path, { body: { frames: 100 }, expect: 202 });
    await ask('delete', path);
  });

  it('calibrates several cameras together', async () => {
    const path = '/api/calibration';
    await ask('get', path);
    await ask('delete', path, { expect: 409 });
    for (const what of ['accept', 'reject']) await ask('post', `${path}/${what}`, { expect: 409 });
    await ask('post', path, { body: { cameras: [0, 9] }, expect: 422 });
    const request = { frames: 1, seconds: 1 };
    await ask('post', path, { body: request, expect: 202 });
    await ask('post', path, { body: request, expect: 409 });
    await becomes(path, ({ state }) => state === 'done');
    await ask('post', `${path}/accept`, { body: { force: true } });
    await ask('post', path, { body: request, expect: 202 });
    await becomes(path, ({ state }) => state === 'done');
    await ask('post', `${path}/reject`);
    await ask('post', path, { body: { frames: 1, seconds: 60 }, expect: 202 });
    await ask('delete', path);
  });

  it('refuses what is not there', async () => {
    await ask('get', '/api/ws', { expect: 426 });
    const answer = await fetch(service.address('api/nothing'));
    assert.equal(answer.status, 404);
    checkJson('openapi#/components/schemas/Error', await answer.json(), 'an unknown route');
    const wrong = await fetch(service.address('api/status'), { method: 'DELETE' });
    assert.equal(wrong.status, 405);
    assert.equal(wrong.headers.get('allow'), 'GET');
    checkJson('openapi#/components/schemas/Error', await wrong.json(), 'a wrong method');
  });

  it('was asked for everything', () => {
    for (const [path, methods] of Object.entries(openApi.paths)) {
      for (const method of Object.keys(methods)) assert.ok(seen.has(`${method} ${path}`), `${method} ${path} was not asked`);
    }
  });
});
