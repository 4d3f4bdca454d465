// SPDX-License-Identifier: Apache-2.0
// A backup of one service, restored by another with its own state folder.
//   SSLV_CTL  the tool; default: the release build
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readdirSync, readFileSync, rmdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { join, relative } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { gzipSync } from 'node:zlib';
import { becomes, createService, freeTcpPort, root } from './service.mjs';

const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const MIB = 1024 * 1024;
const first = await createService('239.255.77.112');
const spare = await createService('239.255.77.113');
const PASSWORD = 'correct horse';

async function ask(service, method, path, { body, headers, expect = 200 } = {}) {
  const isBytes = body === undefined || Buffer.isBuffer(body) || typeof body === 'string';
  const answer = await fetch(service.address(path), { method, headers, body: isBytes ? body : JSON.stringify(body) });
  const bytes = Buffer.from(await answer.arrayBuffer());
  assert.equal(answer.status, expect, `${method} ${path}: ${bytes.toString().slice(0, 500)}`);
  return answer.headers.get('content-type').startsWith('application/json') ? JSON.parse(bytes) : bytes;
}
const get = (service, path, options) => ask(service, 'GET', path, options);
const post = (service, path, body, expect = 200) => ask(service, 'POST', path, { body, expect });
/** The settings as text, for comparison byte for byte. */
const settingsText = async (service) => JSON.stringify((await get(service, 'api/settings')).settings);
const ctl = (service, ...words) => spawnSync(CTL, ['--daemon', service.address(''), ...words], { encoding: 'utf8' });

const sumOf = (bytes) => createHash('sha256').update(bytes).digest('hex');
/** All files in a folder: names, permissions and hashes, except the event log of this computer, which keeps growing. */
function bytesOf(folder, at = folder, out = {}) {
  for (const entry of readdirSync(at, { withFileTypes: true })) {
    const path = join(at, entry.name);
    if (entry.isDirectory()) bytesOf(folder, path, out);
    else if (!entry.name.startsWith('events.json')) out[relative(folder, path)] = `${statSync(path).mode.toString(8)} ${sumOf(readFileSync(path))}`;
  }
  return out;
}
/** Files that a backup restores. */
const broughtFiles = (service) => Object.fromEntries(Object.entries(bytesOf(service.stateFolder))
  .filter(([name]) => /^(tables\/.*|profiles\.json|calibrations\.json)$/.test(name)).sort());

function partsOf(backup) {
  const folder = join(first.folder, 'parts');
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder);
  execFileSync('tar', ['-xz', '-C', folder], { input: backup });
  return new Map(execFileSync('tar', ['-tz'], { input: backup, encoding: 'utf8' }).trim().split('\n').map((name) => [name, readFileSync(join(folder, name))]));
}
/** A backup of these files, with correct checksums unless `sums` is given. */
function packed(parts, { sums } = {}) {
  const all = new Map(parts);
  all.set('SHA256SUMS', sums ?? [...all].filter(([name]) => name !== 'SHA256SUMS').map(([name, bytes]) => `${sumOf(bytes)}  ${name}\n`).join(''));
  const folder = join(first.folder, 'packed');
  rmSync(folder, { recursive: true, force: true });
  for (const [name, bytes] of all) {
    mkdirSync(join(folder, name, '..'), { recursive: true });
    writeFileSync(join(folder, name), bytes);
  }
  return execFileSync('tar', ['-cz', '--format=ustar', '-C', folder, ...all.keys()], { maxBuffer: 64 * MIB });
}
const changed = (parts, name, change) => new Map(parts).set(name, change(parts.get(name)));
const changedJson = (parts, name, change) => changed(parts, name, (bytes) => {
  const json = JSON.parse(bytes);
  change(json);
  return Buffer.from(JSON.stringify(json));
});

/** Checks that both routes refuse the backup with an error matching `line`, and that nothing changes. */
async function refuses(backup, line, status = 422) {
  const was = { files: bytesOf(spare.stateFolder), settings: await settingsText(spare) };
  for (const path of ['api/backup/check', 'api/backup/restore']) {
    const { error } = await post(spare, path, backup, status);
    assert.match(error, line);
    assert.ok(!error.includes('\n'), error);
  }
  assert.deepEqual({ files: bytesOf(spare.stateFolder), settings: await settingsText(spare) }, was);
}

describe('a backup', () => {
  let backup, bundle, port;

  /** Fills the service with everything that a backup contains. */
  before(async () => {
    port = await freeTcpPort();
    first.settings.panel.port = port;
    first.settings.cameras[0].stages = { detect_robots: { memory_ms: 0, max_rms_mm: 8 } };
    spare.settings.panel.port = await freeTcpPort();
    spare.settings.site = 'Spare';
    spare.settings.cameras = [{ ...spare.settings.cameras[0], name: 'not set up', stages: { detect_robots: { max_rms_mm: 8, memory_ms: 0 } } }]; // in another order
    await first.start();
    await first.statusBecomes(({ cameras }) => cameras.every(({ frames }) => frames > 20));
    await first.patch({ op: 'add', path: '/own_labels', value: [{ value: 20, name: 'tape', color: '#0a141e' }] });
    const learning = 'api/cameras/0/colors/learning';
    await post(first, learning, {}, 202);
    await becomes(() => get(first, learning), ({ state }) => state === 'done');
    await post(first, `${learning}/accept`, {});
    await ask(first, 'PUT', 'api/profiles/Evening', { body: {} });
    const paint = { op: 'paint', label: 'tape', shape: 'box', at: [20, 40, 40], radius: [1, 1, 1] };
    await post(first, 'api/cameras/0/colors/edits', { commands: [paint] });
    await post(first, 'api/cameras/1/colors/edits', { commands: [{ ...paint, label: 'black' }] });
    await ask(first, 'PUT', 'api/profiles/Division%20A', { body: {} });
    await first.patch({ op: 'replace', path: '/cameras/0/mask/exclude', value: [{ points: [[10, 10], [60, 10], [60, 60]] }] }, { op: 'replace', path: '/site', value: 'Hall 3, Bordeaux' });
    const calibration = 'api/cameras/1/calibration';
    await post(first, calibration, { frames: 1, height_mm: 4000 }, 202);
    await becomes(() => get(first, calibration), ({ state }) => state === 'done');
    await post(first, `${calibration}/accept`, { force: true });
    backup = await get(first, 'api/backup');
    bundle = await get(first, 'api/support');
  });
  after(async () => { await first.end(); await spare.end(); });

  it('is a file that other tools read', () => {
    const parts = partsOf(backup);
    const tables = readdirSync(join(first.stateFolder, 'tables'));
    assert.ok(tables.length >= 3, 'learnt, edited, and one of the other camera');
    assert.deepEqual([...parts.keys()].sort(), ['SHA256SUMS', 'calibrations.json', 'manifest.json', 'profiles.json', 'settings.json', ...tables.map((name) => `tables/${name}`)].sort());
    execFileSync('sha256sum', ['--check', '--strict', 'SHA256SUMS'], { cwd: join(first.folder, 'parts') });
  });

  it('is named after the site and the time', async () => {
    const answer = await fetch(first.address('api/backup'));
    assert.match(answer.headers.get('content-disposition'), /^attachment; filename="Hall-3-Bordeaux-\d{8}-\d{6}\.sslvision"$/);
    await ask(first, 'GET', 'api/backup?passwords=perhaps', { expect: 400 });
  });

  it('is not needed for the settings of the same computer: their export is taken, with tables', async () => {
    const file = join(first.folder, 'export.json');
    assert.equal(ctl(first, 'settings', 'export', file).status, 0);
    assert.match(JSON.parse(readFileSync(file)).cameras[0].colors.table, /^[0-9a-f]{16}$/);
    const imported = ctl(first, 'settings', 'import', file);
    assert.deepEqual([imported.status, imported.stderr], [0, '']);
    await first.stop(); // two services cannot share the port that is in the settings
    await spare.start();
    const elsewhere = ctl(spare, 'settings', 'import', file);
    assert.equal(elsewhere.status, 1);
    assert.match(elsewhere.stderr, /\/cameras\/0\/colors\/table: "[0-9a-f]{16}" is not allowed.*A backup brings another computer's settings/);
  });

  it('is refused if damaged or not a backup, and nothing changes', async () => {
    await post(spare, 'api/cameras/0/colors/edits', { commands: [{ op: 'paint', label: 'pink', shape: 'box', at: [20, 40, 40], radius: [1, 1, 1] }] });
    await ask(spare, 'PUT', 'api/profiles/Own', { body: {} });
    const parts = partsOf(backup);
    const sums = parts.get('SHA256SUMS');
    for (const name of parts.keys()) {
      // In JSON files, a byte whose change leaves valid JSON.
      const at = name.endsWith('.json') ? parts.get(name).indexOf('"time"') + 3 : parts.get(name).length >> 1;
      const tampered = changed(parts, name, (bytes) => {
        const copy = Buffer.from(bytes);
        copy[name === 'settings.json' ? copy.indexOf('Hall') : at] ^= 1;
        return copy;
      });
      await refuses(packed(tampered, { sums: tampered.get('SHA256SUMS') }), name === 'SHA256SUMS' ? /SHA256SUMS/ : new RegExp(`^${name.replace('.', '\\.')}: `));
    }
    for (const name of [...parts.keys()].filter((one) => one !== 'SHA256SUMS')) {
      const without = new Map(parts);
      without.delete(name);
      await refuses(packed(without, { sums }), new RegExp(`${name.replace('.', '\\.')}`));
    }
    for (const size of [backup.length - 1, backup.length >> 1, 100, 10]) await refuses(backup.subarray(0, size), /^this is not a complete backup: |^SHA256SUMS: is not in the file/);
    for (let at = 20; at < backup.length - 8; at += backup.length >> 3) {
      const tampered = Buffer.from(backup);
      tampered[at] ^= 0x10;
      await refuses(tampered, /./);
    }
    await refuses(Buffer.from('{"site": "Hall"}\n'), /^this is not a complete backup: /);
    await refuses(Buffer.from(''), /^the file is empty; expected a backup$/);
    await refuses(gzipSync('no archive'), /^this is not a complete backup: /);
    await refuses(bundle, /^manifest\.json: is not in the file; expected a backup of ssl-visiond$/);
    await refuses(packed(new Map(parts).set('notes.txt', Buffer.from('x'))), /^notes\.txt: is not allowed in a backup; expected settings\.json, profiles\.json, /);
  });

  it('is refused if it is from another program or has an invalid value', async () => {
    const parts = partsOf(backup);
    const json = (name, change) => packed(changedJson(parts, name, change));
    const table = [...parts.keys()].find((name) => name.startsWith('tables/'));
    await refuses(json('manifest.json', (it) => { it.format = 'something else'; }), /^manifest\.json: \/format: .* expected "ssl-visiond backup"$/);
    await refuses(json('manifest.json', (it) => { it.format_version = 2; }), /^manifest\.json: \/format_version: 2 is newer than this program, which reads backups up to 1; install the program that made it, "[\d.]+/);
    await refuses(json('manifest.json', (it) => { it.site = 'a\u0007b'; }), /^manifest\.json: \/site: /);
    await refuses(json('settings.json', (it) => { it.version = 999; }), /^settings\.json: \/version: 999 is newer than this program/);
    await refuses(json('settings.json', (it) => { it.settings.field.field_length = -5; }), /^settings\.json: \/field\/field_length: -5 is not allowed; expected /);
    await refuses(json('settings.json', (it) => { it.settings.colour = 1; }), /^settings\.json: \/colour: no such parameter; known: /);
    await refuses(json('settings.json', (it) => { it.settings.patterns_file = '/etc/hostname'; }), /^settings\.json: \/patterns_file: "\/etc\/hostname" is not allowed here/);
    await refuses(json('settings.json', (it) => { it.settings.cameras[1].colors.table = '0123456789abcdef'; }), /^settings\.json: \/cameras\/1\/colors\/table: "0123456789abcdef" is not allowed; expected a table/);
    await refuses(json('settings.json', (it) => { it.settings.own_labels = []; }), /^settings\.json: \/cameras\/0\/colors\/table: tables\/[0-9a-f]{16}\.lut: /);
    await refuses(json('settings.json', (it) => { it.revision = -1; }), /^settings\.json: \/revision: /);
    await refuses(json('settings.json', (it) => { delete it.history[0].changes[0].path; }), /^settings\.json: \/history\/0: /);
    await refuses(json('settings.json', (it) => { it.history.reverse(); }), /^settings\.json: \/history\/1: /);
    await refuses(json('profiles.json', (it) => { it.profiles[0].name = 'a/b'; }), /^profiles\.json: name: "a\/b" is not allowed/);
    await refuses(json('profiles.json', (it) => { it.profiles.reverse(); }), /^profiles\.json: /);
    await refuses(json('calibrations.json', (it) => { it.cameras[0].records[0].calibration.focal_length = 'long'; }), /^calibrations\.json: \/cameras\/0\/records\/0\/calibration\/focal_length: /);
    await refuses(packed(new Map(parts).set('passwords.json', Buffer.from('{"admin": "plain"}'))), /^passwords\.json: expected the hash of an admin's password/);
    await refuses(packed(changed(parts, table, (bytes) => bytes.subarray(1))), new RegExp(`^${table.replace('.', '\\.')}: its contents do not match its name`));
    const deep = Buffer.from(`{"version": 1, "revision": 1, "history": [], "settings": ${'{"a":'.repeat(100)}1${'}'.repeat(100)}}`);
    await refuses(packed(new Map(parts).set('settings.json', deep)), /^settings\.json: .*64 levels/);
  });

  it('is refused if too large', async () => {
    await refuses(Buffer.alloc(8 * MIB + 1), /^the body is larger than 8 MiB$/, 413);
    const bomb = packed(new Map(partsOf(backup)).set('settings.json', Buffer.alloc(33 * MIB, 0x20)));
    assert.ok(bomb.length < MIB);
    await refuses(bomb, /^this is not a complete backup: unpacked, it is larger than 16 MiB$/);
    const file = join(first.folder, 'large.sslvision');
    writeFileSync(file, Buffer.alloc(8 * MIB + 1));
    const { status, stderr } = ctl(spare, 'restore', file);
    assert.deepEqual([status, stderr], [1, `ssl-visionctl: ${file}: has ${8 * MIB + 1} bytes; expected a backup, of 8 MiB at most\n`]);
  });

  it('is refused as a whole when the disk does not take it', async () => {
    const blocked = join(spare.stateFolder, 'settings.json.new');
    mkdirSync(blocked);
    const was = { files: bytesOf(spare.stateFolder), settings: await settingsText(spare), profiles: await get(spare, 'api/profiles') };
    assert.match((await post(spare, 'api/backup/restore', backup, 507)).error, /settings\.json\.new: /);
    assert.deepEqual({ files: bytesOf(spare.stateFolder), settings: await settingsText(spare), profiles: await get(spare, 'api/profiles') }, was);
    rmdirSync(blocked);
  });

  it('says what it holds before anything changes', async () => {
    const was = bytesOf(spare.stateFolder);
    const contents = await post(spare, 'api/backup/check', backup);
    assert.deepEqual(bytesOf(spare.stateFolder), was);
    const { time, computer, version, changes, revision, steps, ...others } = contents;
    assert.ok(Math.abs(time - Date.now() / 1000) < 3600 && computer && /^\d/.test(version) && changes.length > 0 && steps > 3);
    assert.equal(revision, (await get(spare, 'api/settings')).revision);
    assert.deepEqual(others, {
      site: 'Hall 3, Bordeaux', cameras: first.settings.cameras.map(({ id, name }) => ({ id, name })), tables: readdirSync(join(first.stateFolder, 'tables')).length,
      profiles: ['Division A', 'Evening'], calibrations: 1, passwords: false, keeps_passwords: false, files_elsewhere: [],
    });
    await ask(spare, 'POST', 'api/backup/restore', { body: backup, headers: { 'If-Match': String(revision - 1) }, expect: 409 });
    assert.deepEqual(bytesOf(spare.stateFolder), was);
  });

  it('makes a spare computer the same as the first, byte for byte, live and after a restart', async () => {
    await first.start();
    const wanted = { settings: await settingsText(first), history: await get(first, 'api/settings/history'), files: broughtFiles(first) };
    const revision = (await get(first, 'api/settings')).revision;
    const own = { settings: await settingsText(spare), profiles: await get(spare, 'api/profiles') };
    const ownTables = Object.keys(broughtFiles(spare)).filter((name) => name.startsWith('tables/'));
    const file = join(first.folder, 'hall.sslvision');
    assert.deepEqual(ctl(first, 'backup', file).stderr, `written to ${file}\n`);
    await first.stop();
    const tried = ctl(spare, 'restore', '--dry-run', file);
    assert.match(tried.stdout, /^site +Hall 3, Bordeaux$/m);
    assert.match(tried.stdout, /^profiles +Division A, Evening$/m);
    assert.equal(await settingsText(spare), own.settings);

    const restored = ctl(spare, 'restore', file);
    assert.deepEqual([restored.status, restored.stderr], [0, '']);
    assert.match(restored.stdout, new RegExp(`restored, revision ${revision + 1}; \`ssl-visionctl undo ${revision + 1}\``));
    await becomes(() => get(spare, 'api/events'), ({ entries }) => entries.some(({ id, title }) => id === 'backup_restored' && title.startsWith('Backup of Hall 3, Bordeaux restored: ')));
    spare.settings.panel.port = port; // it took over the port of the first service
    const isTheSame = async () => {
      assert.equal(await settingsText(spare), wanted.settings);
      const [step, ...history] = await get(spare, 'api/settings/history');
      assert.deepEqual([step.revision, step.what], [revision + 1, 'backup of Hall 3, Bordeaux']);
      assert.deepEqual(history, wanted.history);
      const files = broughtFiles(spare);
      for (const name of ownTables) delete files[name];
      assert.deepEqual(files, wanted.files);
      assert.deepEqual((await get(spare, 'api/profiles')).profiles.map(({ name }) => name), ['Division A', 'Evening']);
      assert.equal((await get(spare, 'api/cameras/1/calibration')).history.length, 1);
      await spare.statusBecomes(({ cameras }) => cameras.length === 2 && cameras.every(({ frames, robots }) => frames > 20 && robots > 0));
    };
    await isTheSame();
    await spare.stop();
    await spare.start();
    await isTheSame();
    assert.equal((await get(spare, 'api/status')).alerts.filter(({ id }) => /settings/.test(id)).length, 0);

    // Undo: the state folder contains the previous state, and restoring was one step in the settings' history.
    const before = join(spare.stateFolder, 'before_restore.sslvision');
    const earlier = partsOf(readFileSync(before));
    assert.equal(JSON.stringify(JSON.parse(earlier.get('settings.json')).settings), own.settings);
    await post(spare, 'api/settings/undo', { revision: revision + 1 });
    const back = JSON.parse(own.settings);
    spare.settings.panel.port = back.panel.port;
    assert.deepEqual(JSON.parse(await settingsText(spare)), back);
    const again = ctl(spare, 'restore', before);
    assert.deepEqual([again.status, again.stderr], [0, '']);
    assert.deepEqual(await get(spare, 'api/profiles'), own.profiles);
    assert.equal(await settingsText(spare), own.settings);
  });

  it('contains passwords only on request, and replaces none', async () => {
    await spare.stop(); // open connections to its earlier port would still reach it
    await first.start();
    const setPassword = (service, password) => ask(service, 'PUT', 'api/passwords/admin', { body: { password } });
    const cookieOf = async (service, password, expect = 200) => {
      const answer = await fetch(service.address('api/session'), { method: 'POST', body: JSON.stringify({ password }) });
      assert.equal(answer.status, expect);
      return answer.headers.get('set-cookie')?.split(';')[0];
    };
    await setPassword(first, PASSWORD);
    await first.opensToOthers();
    await ask(first, 'GET', 'api/backup?passwords=true', { expect: 401 });
    const headers = { Cookie: await cookieOf(first, PASSWORD) };
    assert.ok(!partsOf(await get(first, 'api/backup', { headers })).has('passwords.json'));
    const secret = join(first.folder, 'secret.sslvision');
    const saved = spawnSync(CTL, ['--daemon', first.address(''), 'backup', '--with-passwords', secret], { encoding: 'utf8', env: { ...process.env, SSL_VISIOND_PASSWORD: PASSWORD } });
    assert.deepEqual([saved.status, saved.stderr], [0, `written to ${secret}\n`]);
    assert.equal(statSync(secret).mode & 0o777, 0o600);
    const hashes = readFileSync(join(first.stateFolder, 'passwords.json'));
    // The service does not even read a large file from a client without permission to make changes.
    await ask(first, 'POST', 'api/backup/check', { body: Buffer.alloc(2 * MIB), expect: 401 });
    await first.stop();
    await spare.start();

    assert.ok(!existsSync(join(spare.stateFolder, 'passwords.json')));
    assert.equal((await post(spare, 'api/backup/check', readFileSync(secret))).passwords, true);
    assert.equal((await post(spare, 'api/backup/restore', readFileSync(secret))).passwords, 'restored');
    spare.settings.panel.port = port;
    await spare.opensToOthers();
    assert.deepEqual(readFileSync(join(spare.stateFolder, 'passwords.json')), hashes);
    assert.equal(statSync(join(spare.stateFolder, 'passwords.json')).mode & 0o777, 0o600);
    await post(spare, 'api/backup/restore', readFileSync(secret), 401);
    await spare.stop();
    rmSync(join(spare.stateFolder, 'passwords.json'));
    await spare.start();
    await setPassword(spare, 'another horse');
    await spare.opensToOthers();
    const own = { Cookie: await cookieOf(spare, 'another horse') };
    assert.equal((await ask(spare, 'POST', 'api/backup/restore', { body: readFileSync(secret), headers: own })).passwords, 'kept');
    await cookieOf(spare, PASSWORD, 401);
  });

  it('is not made if a colour table is missing, as it could not be restored', async () => {
    await spare.stop();
    rmSync(join(spare.stateFolder, 'passwords.json'));
    rmSync(join(spare.stateFolder, 'tables'), { recursive: true });
    await spare.start();
    const { error } = await ask(spare, 'GET', 'api/backup', { expect: 507 });
    assert.match(error, /^\/cameras\/0\/colors\/table: .*tables\/[0-9a-f]{16}\.lut is missing or damaged/);
    // Restoring a backup repairs that.
    await post(spare, 'api/backup/restore', backup);
    await get(spare, 'api/backup');
    await spare.statusBecomes(({ alerts }) => !alerts.some(({ title }) => /colors\/table/.test(title)));
  });
});
