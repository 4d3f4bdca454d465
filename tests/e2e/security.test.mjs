// SPDX-License-Identifier: Apache-2.0
// Access, permissions and secrets: each threat of docs/security.md, against the real service, also from an address
// other than its loopback.
//   SSLV_CTL  ssl-visionctl; default: the release build's
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { existsSync, mkdirSync, readFileSync, statSync, symlinkSync, writeFileSync } from 'node:fs';
import { createServer, request } from 'node:http';
import { connect } from 'node:net';
import { networkInterfaces } from 'node:os';
import { join } from 'node:path';
import { after, before, beforeEach, describe, it } from 'node:test';
import { gunzipSync } from 'node:zlib';
import { answerPings, becomes, createService, DAEMON, freeUdpPort, root } from './service.mjs';

const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const ADMIN = 'correct horse', VIEWER = 'battery staple';
const service = await createService('239.255.77.101');
const passwordsFile = join(service.stateFolder, 'passwords.json');

/** An address of this computer other than its loopback, as another computer would use. */
const outside = Object.values(networkInterfaces()).flat().find(({ family, internal }) => family === 'IPv4' && !internal)?.address;
const noOutside = outside ? false : 'this computer has no address but its loopback';

/** {status, headers, text, json}; status 0 if there is no answer. */
function ask(method, path, { body, cookie, headers = {}, from = '127.0.0.1' } = {}) {
  const text = body === undefined ? undefined : typeof body === 'string' ? body : JSON.stringify(body);
  return new Promise((resolve) => {
    const sent = request({
      host: from, port: service.settings.panel.port, path: `/${path}`, method, agent: false,
      headers: { ...(cookie ? { Cookie: cookie } : {}), ...(text === undefined ? {} : { 'Content-Length': Buffer.byteLength(text) }), ...headers },
    }, (answer) => {
      const parts = [];
      answer.on('data', (part) => parts.push(part));
      answer.on('end', () => {
        const bytes = Buffer.concat(parts);
        let json = null;
        try { json = JSON.parse(bytes.toString()); } catch { /* no JSON */ }
        resolve({ status: answer.statusCode, headers: answer.headers, bytes, text: bytes.toString(), json });
      });
    });
    sent.on('error', () => resolve({ status: 0, headers: {}, bytes: Buffer.alloc(0), text: '', json: null }));
    sent.end(text);
  });
}

const cookieOf = ({ headers }) => headers['set-cookie'][0].split(';')[0];
async function signIn(password, options = {}) {
  const answer = await ask('POST', 'api/session', { body: { password }, ...options });
  assert.equal(answer.status, 200, answer.text);
  return cookieOf(answer);
}
const rename = (site) => [{ op: 'replace', path: '/site', value: site }];

async function ctl(args, input = '', env = {}) {
  const child = spawn(CTL, args, { env: { ...process.env, ...env }, stdio: ['pipe', 'pipe', 'pipe'] });
  let output = '';
  for (const stream of [child.stdout, child.stderr]) stream.on('data', (part) => { output += part; });
  child.stdin.on('error', () => {});
  child.stdin.end(input);
  const [code] = await once(child, 'close');
  return { code, output };
}
const passwd = (password, ...more) => ctl(['passwd', '--state', service.stateFolder, ...more], `${password}\n`);

/** A raw connection that collects the data received. */
async function open(text, address = '127.0.0.1', localAddress = undefined) {
  const socket = connect({ port: service.settings.panel.port, host: localAddress === outside && outside ? outside : address, localAddress });
  socket.received = '';
  socket.on('data', (part) => { socket.received += part.toString('latin1'); });
  socket.on('error', () => {});
  await once(socket, 'connect');
  if (text) socket.write(text);
  return socket;
}
const upgrade = (headers) => `GET /api/ws HTTP/1.1\r\n${headers}Connection: Upgrade\r\nUpgrade: websocket\r\n`
  + 'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n';
async function handshake(headers) {
  const socket = await open(upgrade(headers));
  await becomes(() => socket.received.includes('\r\n\r\n'), Boolean);
  answerPings(socket);
  return socket;
}

/** Restarts the service with no password and these panel settings. */
async function startAfresh(panel = {}) {
  await service.stop();
  await service.forget();
  service.settings.panel = { port: 0, ...panel };
  await service.start();
}

async function endsAtOnce(settings) {
  const file = join(service.folder, 'other.json');
  writeFileSync(file, JSON.stringify(settings));
  const child = spawn(DAEMON, ['--config', file], { env: { ...process.env, STATE_DIRECTORY: service.stateFolder }, stdio: ['ignore', 'ignore', 'pipe'] });
  let text = '';
  child.stderr.on('data', (part) => { text += part; });
  const [code] = await once(child, 'close');
  return { code, text };
}

describe('a service without a password', () => {
  before(() => startAfresh());
  after(() => service.stop());

  it('can be reached from its own computer only', { skip: noOutside }, async () => {
    assert.equal((await ask('GET', 'api/session')).json.may, 'change');
    assert.equal((await ask('GET', 'api/session', { from: outside })).status, 0);
  });

  it('does not start with an address that others reach, and says why', async () => {
    for (const address of ['0.0.0.0', '::', '192.0.2.1']) {
      const { code, text } = await endsAtOnce({ panel: { port: 0, address } });
      assert.equal(code, 78, text);
      assert.match(text, /\/panel\/address: .* no password is set; set one first \(sudo ssl-visionctl passwd\)/);
      assert.equal(text.trim().split('\n').length, 1, text);
    }
  });

  it('refuses to listen on other addresses if asked over the network', async () => {
    const answer = await ask('PATCH', 'api/settings', { body: [{ op: 'replace', path: '/panel/address', value: '0.0.0.0' }] });
    assert.equal(answer.status, 422);
    assert.match(answer.json.error, /no password is set/);
  });

  it('refuses pages of other sites and unknown host names', async () => {
    const { port } = service.settings.panel;
    const evil = `evil.example:${port}`;
    const body = rename('Stolen');
    for (const headers of [{ Origin: 'http://evil.example' }, { Origin: `http://${evil}`, Host: evil }, { Host: evil }, { Origin: 'null' }]) {
      assert.equal((await ask('PATCH', 'api/settings', { body, headers })).status, 403, JSON.stringify(headers));
    }
    for (const path of ['', 'api/settings', 'api/cameras/0/snapshot.jpg', 'metrics']) assert.equal((await ask('GET', path, { headers: { Host: evil } })).status, 403, path);
    for (const headers of [`Host: ${evil}\r\nOrigin: http://${evil}\r\n`, `Host: 127.0.0.1:${port}\r\nOrigin: http://evil.example\r\n`]) {
      const socket = await handshake(headers);
      assert.match(socket.received, /^HTTP\/1\.1 403 /);
      socket.destroy();
    }
    assert.equal((await ask('GET', 'api/settings')).json.settings.site, service.settings.site);
    for (const headers of Object.values((await ask('GET', 'api/status')).headers)) assert.doesNotMatch(String(headers), /\*/);
  });

  it('can be reached by a name that the settings know', async () => {
    const headers = { Host: `vision.example:${service.settings.panel.port}` };
    assert.equal((await ask('GET', 'api/status', { headers })).status, 403);
    await service.patch({ op: 'replace', path: '/panel/names', value: ['vision.example'] });
    assert.equal((await ask('GET', 'api/status', { headers })).status, 200);
    await service.patch({ op: 'replace', path: '/panel/names', value: [] });
  });

  it('is opened to others by the first password, without a restart', { skip: noOutside }, async () => {
    const frames = async () => (await ask('GET', 'api/status')).json.cameras[0].frames;
    await becomes(frames, (count) => count > 0);
    const wrong = await passwd('short');
    assert.deepEqual([wrong.code, wrong.output.trim()], [78, 'ssl-visionctl: password: too short; expected 8 .. 200 characters']);
    const { code, output } = await passwd(ADMIN);
    assert.equal(code, 0, output);
    assert.equal(statSync(passwordsFile).mode & 0o777, 0o600);
    await service.opensToOthers();
    assert.equal((await ask('GET', 'api/session', { from: outside })).status, 200);
    assert.ok(await frames() > 0, 'the same service goes on');
  });
});

describe('a service with passwords', () => {
  before(async () => {
    await startAfresh();
    assert.equal((await passwd(ADMIN)).code, 0);
    await becomes(() => ask('GET', 'api/session'), ({ json }) => json?.may === 'look', ({ text }) => text);
    await service.opensToOthers();
  });
  after(() => service.stop());

  it('lets everybody look and nobody change', async () => {
    assert.equal((await ask('GET', 'api/status')).status, 200);
    assert.equal((await ask('GET', 'api/settings')).status, 200);
    const before = (await ask('GET', 'api/settings')).json;
    for (const [method, path, body] of [
      ['PATCH', 'api/settings', rename('Stolen')], ['POST', 'api/settings/undo', { revision: 2 }], ['PUT', 'api/profiles/x', undefined],
      ['POST', 'api/cameras/0/calibration', {}], ['POST', 'api/cameras/0/colors/edits', {}], ['POST', 'api/cameras/0/controls/light', { value: 0 }],
      ['PUT', 'api/passwords/admin', { password: 'stolen horse' }], ['POST', 'api/match_lock', { opened: true }], ['GET', 'api/support', undefined],
    ]) {
      for (const cookie of [undefined, 'ssl_visiond=1', `ssl_visiond_${service.settings.panel.port}=${'0'.repeat(64)}`]) {
        const answer = await ask(method, path, { body, cookie });
        assert.equal(answer.status, 401, `${method} ${path}: ${answer.text}`);
        assert.match(answer.json.error, /sign in with the admin's password first/);
      }
    }
    assert.deepEqual((await ask('GET', 'api/settings')).json, before);
  });

  it('sets a session cookie that scripts cannot read and other sites do not send', async () => {
    const answer = await ask('POST', 'api/session', { body: { password: ADMIN } });
    assert.match(answer.headers['set-cookie'][0], /^ssl_visiond_\d+=[0-9a-f]{64}; HttpOnly; SameSite=Strict; Path=\/; Max-Age=\d+$/);
    assert.equal(answer.json.may, 'change');
    const cookie = cookieOf(answer);
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('Ours'), cookie })).status, 200);
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('Theirs'), cookie, headers: { Origin: 'http://evil.example' } })).status, 403);
    assert.equal((await ask('DELETE', 'api/session', { cookie })).json.may, 'look');
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('Theirs'), cookie })).status, 401);
    assert.equal((await ask('GET', 'api/settings')).json.settings.site, 'Ours');
  });

  it('requires the viewers\' password once it is set, and closes open views', async () => {
    const { port } = service.settings.panel;
    const socket = await handshake(`Host: 127.0.0.1:${port}\r\n`);
    assert.match(socket.received, /^HTTP\/1\.1 101 /);
    const film = await open(`GET /api/cameras/0/stream.mjpg HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\n\r\n`);
    await becomes(() => film.received.length, (length) => length > 10_000);
    const admin = await signIn(ADMIN);
    const own = await handshake(`Host: 127.0.0.1:${port}\r\nCookie: ${admin}\r\n`);

    const answer = await ask('PUT', 'api/passwords/viewer', { body: { password: VIEWER, admin_password: ADMIN }, cookie: admin });
    assert.equal(answer.status, 200, answer.text);
    await Promise.all([socket, film].map((one) => becomes(() => one.closed, Boolean)));
    assert.ok(!own.closed);
    own.destroy();
    for (const path of ['api/status', 'api/settings', 'api/cameras/0/snapshot.jpg', 'api/cameras/0/stream.mjpg', 'api/log', 'api/schema']) {
      assert.equal((await ask('GET', path)).status, 401, path);
    }
    const refused = await handshake(`Host: 127.0.0.1:${port}\r\n`);
    assert.match(refused.received, /^HTTP\/1\.1 401 /);
    refused.destroy();
    assert.equal((await ask('GET', '')).status, 200, 'the page that asks for the password');
    for (const path of ['metrics', 'healthz']) assert.equal((await ask('GET', path)).status, 200, `${path} is for monitoring`);

    const viewer = await signIn(VIEWER);
    assert.equal((await ask('GET', 'api/status', { cookie: viewer })).status, 200);
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('Theirs'), cookie: viewer })).status, 401);
    assert.equal((await ask('GET', 'api/support', { cookie: viewer })).status, 401);
    const gone = await ask('PUT', 'api/passwords/viewer', { body: { password: '', admin_password: ADMIN }, cookie: await signIn(ADMIN) });
    assert.equal(gone.status, 200, gone.text);
    assert.equal((await ask('GET', 'api/status')).status, 200);
  });

  it('ends all sessions when the password is changed by ssl-visionctl', async () => {
    const cookie = await signIn(ADMIN);
    assert.equal((await passwd('another horse')).code, 0);
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('Theirs'), cookie })).status, 401);
    assert.equal((await passwd(ADMIN)).code, 0);
  });

  it('delays password guessing', { skip: noOutside }, async () => {
    const guess = (password) => ask('POST', 'api/session', { body: { password }, from: outside });
    // All at once, as one attempt becomes available every ten seconds, and checking a password takes long on a busy
    // computer. The correct one, which restores all attempts, may be among the first.
    let most = 5, guesses = 0;
    const begin = performance.now();
    const late = await becomes(async () => {
      const wrong = Array.from({ length: 20 }, (_, i) => guess(`guess number ${i}`));
      const right = await guess(ADMIN);
      guesses += (await Promise.all(wrong)).filter(({ status }) => status === 401).length;
      if (right.status === 200) most += 5;
      assert.ok(guesses <= most + (performance.now() - begin) / 10_000, `${guesses} guesses`);
      return right;
    }, ({ status }) => status === 429, ({ text }) => text);
    assert.ok(guesses >= 4, `${guesses} guesses`);
    assert.match(late.headers['retry-after'], /^\d+$/);
    await signIn(ADMIN); // from another address
  });

  it('is used by ssl-visionctl with a password', async () => {
    const daemon = ['--daemon', `http://127.0.0.1:${service.settings.panel.port}`];
    const change = ['settings', 'set', '/site', '"By hand"'];
    const none = await ctl([...daemon, ...change]);
    assert.equal(none.code, 1);
    assert.match(none.output, /wants a password: use --password-file, or set SSL_VISIOND_PASSWORD/);
    const wrong = await ctl([...daemon, ...change], '', { SSL_VISIOND_PASSWORD: 'wrong horse' });
    assert.match(wrong.output, /wrong password/);
    const right = await ctl([...daemon, ...change], '', { SSL_VISIOND_PASSWORD: ADMIN });
    assert.equal(right.code, 0, right.output);
    const file = join(service.folder, 'password');
    writeFileSync(file, `${ADMIN}\n`);
    const again = await ctl([...daemon, '--password-file', file, 'settings', 'set', '/site', '"By file"']);
    assert.equal(again.code, 0, again.output);
    assert.equal((await ask('GET', 'api/settings')).json.settings.site, 'By file');
  });

  it('reveals no secrets', async () => {
    const cookie = await signIn(ADMIN);
    await ask('POST', 'api/session', { body: { password: 'typed in the wrong place' } });
    await ask('PUT', 'api/passwords/viewer', { body: { password: VIEWER, admin_password: ADMIN }, cookie });
    assert.equal((await ask('PUT', 'api/profiles/all', { cookie })).status, 200);
    const { admin, viewer } = JSON.parse(readFileSync(passwordsFile, 'utf8'));
    const secrets = [ADMIN, VIEWER, 'typed in the wrong place', admin, viewer, cookie.split('=')[1]];
    await service.logBecomes(/audit: 127\.0\.0\.1 PUT "\/api\/profiles\/all" 200/);
    const texts = { stderr: service.log() };
    for (const path of ['api/settings', 'api/settings/history', 'api/profiles', 'api/profiles/all', 'api/log', 'api/diagnostics', 'api/status', 'api/schema', 'api/session', 'metrics']) {
      const answer = await ask('GET', path, { cookie });
      assert.equal(answer.status, 200, path);
      texts[path] = answer.text;
    }
    const bundle = await ask('GET', 'api/support', { cookie });
    texts.bundle = gunzipSync(bundle.bytes).toString('latin1');
    assert.ok(texts.bundle.includes('settings.json'));
    texts.backup = gunzipSync((await ask('GET', 'api/backup', { cookie })).bytes).toString('latin1');
    assert.ok(texts.backup.includes('profiles.json'));
    for (const file of ['settings.json', 'profiles.json']) texts[file] = readFileSync(join(service.stateFolder, file), 'utf8');
    for (const [where, text] of Object.entries(texts)) {
      for (const secret of secrets) assert.ok(!text.includes(secret), `${where} has ${secret}`);
    }
    assert.doesNotMatch(readFileSync(passwordsFile, 'utf8'), /horse|staple/);
    await ask('PUT', 'api/passwords/viewer', { body: { password: '', admin_password: ADMIN }, cookie });
  });

  it('writes down who changed what, also what was refused', async () => {
    await service.stop(); // only the first refusal in a minute is logged separately
    await service.start();
    await ask('PATCH', 'api/settings', { body: rename('Refused') });
    const cookie = await signIn(ADMIN);
    await ask('PATCH', 'api/settings', { body: rename('Ö'.repeat(200)), cookie });
    await ask('PUT', 'api/profiles/a%0Aaudit:%206.6.6.6', { cookie });
    await ask('PATCH', 'api/settings', { body: rename('Written down'), cookie });
    await service.logBecomes(/changed by 127\.0\.0\.1: .*Written down/);
    const log = service.log();
    assert.match(log, /audit: 127\.0\.0\.1 PATCH "\/api\/settings" 200/);
    assert.match(log, /changed by 127\.0\.0\.1: .*"Ö{100,190} \.\.\.$/m, 'a long change in short');
    assert.match(log, /audit: 127\.0\.0\.1 PATCH "\/api\/settings" 401/);
    assert.doesNotMatch(log, /^audit: 6\.6\.6\.6/m);
  });

  it('reserves sign-in attempts for its own computer and for admins while others guess', { skip: noOutside }, async () => {
    await service.stop(); // restores the sign-in attempts that other tests have used
    await service.start();
    const viewer = await ask('PUT', 'api/passwords/viewer', { body: { password: VIEWER, admin_password: ADMIN }, cookie: await signIn(ADMIN) });
    assert.equal(viewer.status, 200, viewer.text);
    const guess = (password) => ask('POST', 'api/session', { body: { password }, from: outside });
    let guesses = 0, viewers = 0;
    const begin = performance.now();
    for (let i = 0; i < 30; i++) {
      if ((await guess(`guess number ${i}`)).status === 401) guesses++;
      if ((await guess(VIEWER)).status === 200) viewers++;
    }
    assert.ok(guesses >= 1 && viewers >= 1, `${guesses} guesses and ${viewers} right passwords were looked at`);
    const allowed = 6 + (performance.now() - begin) / 10_000;
    assert.ok(guesses <= allowed, `${guesses} guesses: the viewers' password gives none back`);
    const gone = await ask('PUT', 'api/passwords/viewer', { body: { password: '', admin_password: ADMIN }, cookie: await signIn(ADMIN) });
    assert.equal(gone.status, 200, gone.text);
  });

  it('writes down repeated refusals in one line', async () => {
    const cookie = await signIn(ADMIN);
    const begin = performance.now();
    for (let i = 0; i < 300; i++) await ask('PUT', 'api/nothing', { body: {} });
    await ask('PATCH', 'api/settings', { body: rename('After all of them'), cookie });
    await service.logBecomes(/After all of them/);
    const lines = service.log().split('\n').filter((line) => /audit: .*api\/nothing/.test(line)).length;
    const minutes = Math.ceil((performance.now() - begin) / 60_000); // one line per minute
    assert.ok(lines <= 2 + minutes, `${lines} lines in ${minutes} minutes`);
  });

  const waiting = ['', 'GET /api/sta', 'POST /api/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{', 'GET /api/session HTTP/1.1\r\nHost: localhost\r\n\r\n'];

  it('serves requests despite many connections that send none', async () => {
    const addresses = ['127.0.0.2', '127.0.0.3', '127.0.0.4', '127.0.0.5', ...(outside ? [outside] : [])];
    const sockets = [];
    try {
      for (let i = 0; i < 1500; i++) sockets.push(await open(waiting[i % waiting.length], '127.0.0.1', addresses[i % addresses.length]));
      for (let i = 0; i < 20; i++) assert.equal((await ask('GET', 'healthz')).status, 200);
      if (outside) for (let i = 0; i < 20; i++) assert.equal((await ask('GET', 'healthz', { from: outside })).status, 200);
      for (const socket of sockets) assert.doesNotMatch(socket.received, /^HTTP\/1\.1 503 /);
    } finally {
      for (const socket of sockets) socket.destroy();
    }
  });

  it('leaves room for others when one address takes all connections', { skip: noOutside }, async () => {
    const headers = `Host: ${outside}:${service.settings.panel.port}\r\n`;
    const sockets = await Promise.all(Array.from({ length: 300 }, () => open(upgrade(headers), outside)));
    try {
      await becomes(() => sockets.filter(({ received, closed }) => closed || received.includes('\r\n\r\n')), ({ length }) => length === 300, ({ length }) => length);
      const viewers = sockets.filter(({ received }) => received.startsWith('HTTP/1.1 101 '));
      assert.ok(viewers.length <= 128, `${viewers.length} viewers`);
      const refused = sockets.filter(({ received }) => received.startsWith('HTTP/1.1 503 '));
      assert.ok(refused.length > 0);
      for (const { received } of refused) assert.match(received, /too many (connections|viewers) from your address/);
      assert.equal((await ask('GET', 'api/session')).status, 200);
      // Refused connections are closed a moment after their answer.
      await becomes(() => ask('GET', 'api/session', { from: outside }), ({ status }) => status === 200, ({ text }) => text);
    } finally {
      for (const socket of sockets) socket.destroy();
    }
    await becomes(() => ask('GET', 'api/session', { from: outside }), ({ status }) => status === 200, ({ text }) => text);
  });

  it('does not start when its passwords cannot be read', async () => {
    await service.stop();
    const good = readFileSync(passwordsFile);
    writeFileSync(passwordsFile, '{"admin": 7}');
    const { code, text } = await endsAtOnce({ panel: { port: 0 } });
    assert.equal(code, 78, text);
    assert.match(text, /passwords\.json: .*set them again with: ssl-visionctl passwd/);
    writeFileSync(passwordsFile, good);
    await service.start();
  });
});

describe('files that settings name', () => {
  before(() => startAfresh());
  after(() => service.stop());

  /** As a change of the settings, as a dry run, and as a profile: all three are refused without revealing anything
   * of the file. */
  async function refused(path, value) {
    const before = (await ask('GET', 'api/settings')).json;
    const patch = [{ op: 'replace', path, value }];
    const answers = [await ask('PATCH', 'api/settings', { body: patch }), await ask('POST', 'api/settings/check', { body: patch })];
    for (const { status, json } of answers) {
      assert.equal(status, 422, `${path} ${JSON.stringify(value)}: ${JSON.stringify(json)}`);
      assert.match(json.error, /is not allowed here; expected a file in /);
      assert.doesNotMatch(json.error, /root:|No such file|denied/, 'it does not tell what is there');
    }
    assert.deepEqual((await ask('GET', 'api/settings')).json, before);
  }

  it('lie in the service\'s own folders', async () => {
    symlinkSync('/etc', join(service.stateFolder, 'link'));
    for (const file of ['/etc/passwd', '/etc/no-such-file', '../../../../../etc/passwd', 'etc/passwd', join(service.stateFolder, 'link/passwd'), join(service.folder, '../x')]) {
      await refused('/cameras/0/colors/lut_file', file);
      await refused('/patterns_file', file);
      await refused('/cameras/1/source', { backend: 'files', path: file });
    }
    await refused('/cameras/1/source', { backend: 'files', path: '/' });
    await refused('/cameras/1/source', { backend: 'files', path: '/dev/zero' });
  });

  it('may not come from outside through a profile either', async () => {
    const { settings } = (await ask('GET', 'api/settings')).json;
    const saved = await ask('PUT', 'api/profiles/theirs', { body: { settings: { ...settings, patterns_file: '/etc/passwd' } } });
    assert.ok([200, 422].includes(saved.status), saved.text);
    assert.notEqual((await ask('POST', 'api/profiles/theirs/apply', { body: {} })).status, 200);
    assert.equal((await ask('GET', 'api/settings')).json.settings.patterns_file, '');
  });

  it('may lie beside the settings file', async () => {
    mkdirSync(join(service.folder, 'pictures'), { recursive: true });
    const source = { backend: 'files', path: join(service.folder, 'pictures') };
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: source });
    await service.patch({ op: 'replace', path: '/cameras/1/source', value: service.settings.cameras[1].source });
  });

  it('cannot be read or written through their paths', async () => {
    for (const path of ['../state/passwords.json', '%2e%2e/state/passwords.json', 'assets/../../state/passwords.json', '/etc/passwd', '..%2f..%2fetc/passwd', 'api/profiles/..%2fpasswords']) {
      const answer = await ask('GET', path);
      assert.ok([400, 403, 404].includes(answer.status), `${path}: ${answer.status}`);
      await ask('PUT', path, { body: {} });
    }
    assert.ok(!existsSync(passwordsFile));
  });
});

describe('ssl-visionctl', () => {
  let server, answer;
  before(async () => {
    server = createServer((request, response) => answer(response)).listen(0, '127.0.0.1');
    await once(server, 'listening');
  });
  after(() => server.close());
  const asks = (...args) => ctl(['--daemon', `http://127.0.0.1:${server.address().port}`, ...args]);
  const says = (status, json) => { answer = (response) => response.writeHead(status).end(JSON.stringify(json)); };
  const bad = '\u001b]0;x\u0007\u001b[2J\u009b31m\u007f\u202e\u2066\r\nGO';
  const isPlain = (text) => assert.doesNotMatch(text, /[^\P{Cc}\n]|[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/u);

  it('shows a hostile service\'s output as plain text', async () => {
    const profiles = [{ name: bad, time: 0, who: bad }];
    says(200, { profiles });
    const text = await asks('profiles');
    assert.equal(text.code, 0, text.output);
    isPlain(text.output);
    assert.equal(text.output.trim().split('\n').length, 2, text.output);
    const json = await asks('profiles', '--json');
    isPlain(json.output);
    assert.deepEqual(JSON.parse(json.output), profiles);

    says(200, { settings: { site: bad }, revision: 1, version: 2 });
    for (const args of [['settings', 'get'], ['settings', 'get', '/site'], ['settings', 'export'], ['settings', 'get', '/none']]) isPlain((await asks(...args)).output);
    assert.deepEqual(JSON.parse((await asks('settings', 'export')).output), { version: 2, site: bad });
    says(422, { error: bad });
    for (const args of [['status'], ['log'], ['history'], ['settings', 'schema']]) {
      const { code, output } = await asks(...args);
      assert.equal(code, 1);
      isPlain(output);
      assert.equal(output.trim().split('\n').length, 1, output);
    }
  });

  it('limits how much it reads', async () => {
    answer = (response) => {
      response.writeHead(200);
      const more = () => { while (response.write('['.repeat(1 << 20))); };
      response.on('drain', more);
      more();
    };
    const { code, output } = await asks('status');
    assert.equal(code, 1);
    assert.match(output, /sends more than 64 MiB/);
  });
});

describe('names that settings give', () => {
  before(() => startAfresh());
  after(() => service.stop());

  it('are plain text', async () => {
    const before = (await ask('GET', 'api/settings')).json;
    for (const path of ['/site', '/cameras/0/name', '/teams/yellow/name', '/network/vision/interface', '/network/referee/interface', '/panel/address', '/cameras/0/colors/lut_file']) {
      for (const value of ['lo\0;id', 'a\u202eb', 'a\u2066', '\u200f', '\u061c', 'a\nb', '\u001b[2J', '\u009b']) {
        const { status, json } = await ask('PATCH', 'api/settings', { body: [{ op: 'replace', path, value }] });
        assert.equal(status, 422, `${path} ${JSON.stringify(value)}`);
        assert.match(json.error, /^\S+: "[^\n]+" is not allowed; expected a text without control characters/);
        assert.doesNotMatch(json.error, /[\p{Cc}\u202e\u2066\u200f\u061c]/u);
      }
    }
    assert.equal((await ask('PATCH', 'api/settings', { body: [{ op: 'replace', path: '/panel/names', value: ['a\u202e'] }] })).status, 422);
    assert.equal((await ask('PUT', `api/profiles/${encodeURIComponent('a\u202eb')}`)).status, 422);
    assert.deepEqual((await ask('GET', 'api/settings')).json, before);
  });

  it('are compared strictly with host and origin headers', async () => {
    const own = `127.0.0.1:${service.settings.panel.port}`;
    for (const Host of ['[::1]evil.example', '[::1].evil.example:80', '127.0.0.1:evil', `${own}.evil.example`]) assert.equal((await ask('GET', 'api/status', { headers: { Host } })).status, 403, Host);
    for (const Origin of [`x://${own}`, `file://${own}`]) assert.equal((await ask('PATCH', 'api/settings', { body: [], headers: { Origin } })).status, 403, Origin);
  });
});

describe('the match lock', () => {
  const group = '224.5.23.101';
  let port, socket, timer;
  const says = Object.fromEntries(Object.entries({ running: [1, 2], halted: [1, 0], halfTime: [2, 0], over: [13, 0] }).map(([what, [stage, command]]) => [what, Buffer.from([0x10, stage, 0x20, command, 0x3a, 2, 0x0a, 0, 0x42, 2, 0x0a, 0])])); // stage, command, both teams

  const hears = (what) => {
    clearInterval(timer);
    const send = () => socket.send(says[what], port, group);
    send();
    timer = setInterval(send, 50);
  };
  const gameRuns = (wanted) => becomes(() => ask('GET', 'api/session'), ({ json }) => json.match_lock.game_is_running === wanted, ({ text }) => text);
  const lockBecomes = (wanted) => becomes(() => ask('GET', 'api/session'), ({ json }) => json.match_lock.locked === wanted, ({ text }) => text);

  before(async () => {
    port = await freeUdpPort();
    service.settings.network.referee = { enabled: true, group, port, interface: 'lo' };
    await startAfresh();
    socket = createSocket('udp4');
    socket.bind(0, '127.0.0.1');
    await once(socket, 'listening');
    socket.setMulticastInterface('127.0.0.1');
  });
  beforeEach(() => hears('over'));
  after(async () => {
    clearInterval(timer);
    socket.close();
    service.settings.network.referee = { enabled: false };
    await service.stop();
  });

  it('locks settings during play, until an admin unlocks them or the match ends', async () => {
    assert.equal((await ask('POST', 'api/match_lock', { body: { opened: true } })).status, 409, 'no match runs');
    hears('running');
    await lockBecomes(true);
    for (const [method, path, body] of [['PATCH', 'api/settings', rename('Played')], ['POST', 'api/settings/undo', { revision: 2 }], ['POST', 'api/cameras/0/colors/edits', {}],
      ['POST', 'api/cameras/0/controls/light', { value: 0.5 }], ['POST', 'api/profiles/x/apply', {}], ['POST', 'api/backup/restore', {}], ['POST', 'api/cameras/0/calibration', {}]]) {
      const answer = await ask(method, path, { body });
      assert.ok(answer.status === 423 || (path.endsWith('calibration') && answer.status === 422), `${method} ${path}: ${answer.text}`);
    }
    assert.match((await ask('PATCH', 'api/settings', { body: rename('Played') })).json.error, /the game is running.*unlock the settings/);
    assert.equal((await ask('POST', 'api/settings/check', { body: rename('Played') })).status, 200, 'looking is allowed');
    const opened = await ask('POST', 'api/match_lock', { body: { opened: true } });
    assert.deepEqual(opened.json, { game_is_running: true, opened: true, locked: false });
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('Played') })).status, 200);
    for (const pause of ['halted', 'halfTime']) {
      hears(pause);
      await gameRuns(false);
      hears('running');
      await gameRuns(true);
      assert.equal((await ask('GET', 'api/session')).json.match_lock.locked, false, `after ${pause} it is still this match`);
    }
    // It can also be locked again during HALT.
    hears('halted');
    await gameRuns(false);
    assert.equal((await ask('POST', 'api/match_lock', { body: { opened: false } })).status, 200);
    hears('running');
    await lockBecomes(true);
    assert.equal((await ask('POST', 'api/match_lock', { body: { opened: true } })).status, 200);
    hears('over');
    await gameRuns(false);
    hears('running');
    await lockBecomes(true);
  });

  it('can be turned off in the settings', async () => {
    await lockBecomes(false);
    await service.patch({ op: 'replace', path: '/panel/match_lock', value: false });
    hears('running');
    await becomes(() => ask('GET', 'api/status'), ({ json }) => json.referee.game_is_running, ({ json }) => JSON.stringify(json.referee));
    assert.equal((await ask('PATCH', 'api/settings', { body: rename('In the lab') })).status, 200);
  });
});

after(() => service.end());
