// SPDX-License-Identifier: Apache-2.0
// Match logs from outside: a game controller on the network, the service's own packets, and a reader that is written
// from the format's description (docs/recording.md) instead of the service's code.
import assert from 'node:assert/strict';
import { execFile, execFileSync } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { existsSync, mkdirSync, readFileSync, readdirSync, truncateSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, beforeEach, describe, it } from 'node:test';
import { promisify } from 'node:util';
import { gunzipSync } from 'node:zlib';
import { gameController } from './league_messages.mjs';
import { tracked as strangersTracks } from '../strangers/wire.mjs';
import { becomes, createService, freeUdpPort, listenTo, root } from './service.mjs';

const GROUP = '239.255.77.95', TRACKER_GROUP = '239.255.77.96', GC_GROUP = '239.255.77.97';
const VISION = 4, REFEREE = 3, TRACKED = 5;
const service = await createService(GROUP);
const gcPort = await freeUdpPort();
service.settings.network.referee = { enabled: true, group: GC_GROUP, port: gcPort, interface: 'lo' };
service.settings.network.tracker = { enabled: true, group: TRACKER_GROUP, port: await freeUdpPort() };
const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const ctl = (...words) => execFileSync(CTL, ['--daemon', service.address('').slice(0, -1), ...words], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
const folder = join(service.stateFolder, 'recordings');

const gc = createSocket('udp4');
/** The current message of the game controller, sent four times a second; null: none. */
let said = null;
const talking = setInterval(() => { if (said) gc.send(gameController(said), gcPort, GC_GROUP); }, 250);
const TEAMS = { yellow: ['TIGERs Mannheim'], blue: ['Ünïted'], matchType: 1 };
const STOP = 1, START = 2;

const ask = async (method, path, body) => {
  const answer = await fetch(service.address(`api/recordings${path}`), { method, body: body && JSON.stringify(body) });
  const text = await answer.text();
  return { status: answer.status, json: text && JSON.parse(text), headers: answer.headers };
};
const recordings = async () => (await ask('GET', '')).json;
const state = async () => (await recordings()).match_log;
const isNow = (wanted) => becomes(recordings, ({ match_log }) => match_log.state === wanted);
const logs = async () => (await recordings()).logs;
/** The newest log, once the service has indexed it. */
const newestIsRead = async () => (await becomes(logs, (all) => all[0]?.seconds !== null || all[0]?.problem !== ''))[0];

/** A log's messages: [{ time (Unix s), type, bytes }]. */
function messagesOf(packed) {
  const bytes = gunzipSync(packed);
  assert.equal(bytes.toString('latin1', 0, 12), 'SSL_LOG_FILE');
  assert.equal(bytes.readInt32BE(12), 1);
  const messages = [];
  for (let at = 16; at < bytes.length;) {
    const size = bytes.readInt32BE(at + 12);
    messages.push({ time: Number(bytes.readBigInt64BE(at)) * 1e-9, type: bytes.readInt32BE(at + 8), bytes: bytes.subarray(at + 16, at + 16 + size) });
    at += 16 + size;
    assert.ok(at <= bytes.length, 'the last message is whole');
  }
  return messages;
}
const ofType = (messages, type) => messages.filter((message) => message.type === type);

describe('match logs', () => {
  before(async () => {
    gc.bind(0, '127.0.0.1');
    await once(gc, 'listening');
    gc.setMulticastInterface('127.0.0.1');
  });
  beforeEach(() => service.restore());
  afterEach(async () => {
    said = null;
    if (['recording', 'paused'].includes((await state()).state)) await ask('POST', '/match-log', { record: false });
  });
  after(async () => {
    clearInterval(talking);
    gc.close();
    await service.end();
  });

  it('follow the game controller: named by it, without breaks, to the end of the match', async () => {
    assert.deepEqual((await state()), { state: 'waiting', name: null, started_by: null, begin_s: null, seconds: 0, bytes: 0, messages: { vision: 0, referee: 0, tracked: 0 }, lost: 0, refused: 0, error: '' });
    said = { ...TEAMS, stage: 0, command: 0 };
    await service.statusBecomes(({ referee }) => referee.match !== null);
    assert.equal((await state()).state, 'waiting', 'all are halted');
    said = { ...TEAMS, stage: 1, command: STOP };
    const began = (await isNow('recording')).match_log;
    assert.match(began.name, /^\d{4}-\d\d-\d\d_\d\d-\d\d_GROUP_PHASE_TIGERs_Mannheim-vs-_n_ted\.log\.gz$/);
    assert.equal(began.started_by, 'game_controller');
    const { port } = service.settings.network.vision;
    const heard = [];
    const own = await listenTo(GROUP, port, (packet) => heard.push(packet));
    await becomes(state, ({ messages }) => messages.vision > 30 && messages.tracked > 30 && messages.referee > 2 && heard.length > 20);
    own.close();

    said = { ...TEAMS, stage: 2, command: 0 };
    const { vision } = (await isNow('paused')).match_log.messages;
    const { frames } = (await service.statusBecomes(() => true)).cameras[0];
    await service.statusBecomes(({ cameras }) => cameras[0].frames > frames + 10);
    assert.equal((await state()).messages.vision, vision, 'nothing of a break is recorded');
    said = { ...TEAMS, stage: 3, command: STOP };
    await isNow('recording');
    said = { ...TEAMS, stage: 4, command: START, yellow: ['TIGERs Mannheim', undefined, 1] };
    const before = (await state()).messages.referee;
    await becomes(state, ({ messages }) => messages.referee > before + 3);
    said = { ...TEAMS, stage: 13, command: 0 };
    await isNow('waiting');

    const log = await newestIsRead();
    assert.equal(log.name, began.name);
    assert.equal(log.problem, '');
    assert.equal(log.goals, 1);
    const messages = messagesOf(readFileSync(join(folder, log.name)));
    assert.deepEqual(log.messages, { vision: ofType(messages, VISION).length, referee: ofType(messages, REFEREE).length, tracked: ofType(messages, TRACKED).length });
    assert.ok(Math.abs(messages[0].time - log.begin_s) < 1e-3 && Math.abs(messages.at(-1).time - messages[0].time - log.seconds) < 1e-3);
    assert.ok(messages.every(({ time }, i) => i === 0 || time >= messages[i - 1].time), 'in the order of their times');
    const logged = new Set(ofType(messages, VISION).map(({ bytes }) => bytes.toString('base64')));
    assert.ok(heard.every((packet) => logged.has(packet.toString('base64'))), 'every packet that others heard is there');
    execFileSync('gzip', ['-t', join(folder, log.name)]);

    const { json: { events, begin_s, end_s } } = await ask('GET', `/logs/${log.name}/events`);
    // The last message before a break or the end is included if it arrived before the state was polled.
    assert.deepEqual(events.map(({ kind, text }) => `${kind}: ${text}`).filter((text) => /First|Second half$|Normal|goal/.test(text)),
      ['stage: First half', 'stage: Second half', 'command: Normal start', 'goal: Goal for TIGERs Mannheim: 1 : 0']);
    assert.ok(events.every(({ time_s }) => time_s >= -2.1 && time_s <= end_s - begin_s + 1e-3), JSON.stringify(events));
    await becomes(async () => (await fetch(service.address('api/events'))).text(), (text) => text.includes('Match log') && text.includes('ended'), String);
  });

  it('hold our tracks even while they are not sent', async () => {
    const heard = new Set();
    const others = await listenTo(TRACKER_GROUP, service.settings.network.tracker.port, (packet) => heard.add(packet.toString('base64')));
    try {
      await becomes(() => heard.size, (count) => count > 0);
      await service.patch({ op: 'replace', path: '/network/tracker/enabled', value: false });
      assert.equal((await ask('POST', '/match-log', { record: true, name: 'silent' })).status, 200);
      await becomes(state, ({ messages }) => messages.vision > 60 && messages.tracked > 20);
      assert.equal((await ask('POST', '/match-log', { record: false })).status, 200);
    } finally {
      others.close();
    }
    const log = await newestIsRead();
    const messages = messagesOf(readFileSync(join(folder, log.name)));
    const tracked = ofType(messages, TRACKED);
    assert.equal(log.messages.tracked, tracked.length);
    assert.ok(messages.every(({ time }, i) => i === 0 || time >= messages[i - 1].time), 'in the order of their times');
    assert.ok(tracked.every(({ bytes }) => bytes.includes('ssl-visiond')), 'they name their source');
    assert.ok(tracked.slice(-10).every(({ bytes }) => !heard.has(bytes.toString('base64'))), 'they were not sent');
    await ask('DELETE', `/logs/${log.name}`);
  });

  it('are downloaded as they are on the disk', async () => {
    const { name, bytes } = await newestIsRead();
    const answer = await fetch(service.address(`api/recordings/logs/${name}`));
    assert.equal(answer.status, 200);
    assert.equal(answer.headers.get('content-type'), 'application/gzip');
    assert.equal(answer.headers.get('content-length'), String(bytes));
    assert.equal(answer.headers.get('content-disposition'), `attachment; filename="${name}"`);
    assert.deepEqual(Buffer.from(await answer.arrayBuffer()), readFileSync(join(folder, name)));
    const head = await fetch(service.address(`api/recordings/logs/${name}`), { method: 'HEAD' });
    assert.equal(head.headers.get('content-length'), String(bytes));
  });

  it('are recorded by hand, whatever the game controller says', async () => {
    const start = await ask('POST', '/match-log', { record: true, name: 'our test game' });
    assert.equal(start.status, 200, JSON.stringify(start.json));
    assert.match(start.json.match_log.name, /^[\d_-]+_our_test_game\.log\.gz$/);
    assert.equal(start.json.match_log.started_by, 'hand');
    assert.equal((await ask('POST', '/match-log', { record: true })).status, 409);
    assert.equal((await ask('DELETE', `/logs/${start.json.match_log.name}`)).status, 409, 'not while it is written');
    said = { ...TEAMS, stage: 13, command: 0 };
    await becomes(state, ({ messages }) => messages.vision > 5 && messages.referee > 2);
    assert.equal((await ask('POST', '/match-log', { record: false })).status, 200);
    assert.equal((await ask('POST', '/match-log', { record: false })).status, 409);
    const log = await newestIsRead();
    assert.equal(log.name, start.json.match_log.name);
    assert.equal(messagesOf(readFileSync(join(folder, log.name))).length, Object.values(log.messages).reduce((a, b) => a + b));
  });

  it('by hand do not prevent logging a match that begins meanwhile', async () => {
    await ask('POST', '/match-log', { record: true, name: 'warm-up' });
    said = { ...TEAMS, yellow: ['Third team'], stage: 1, command: START };
    await service.statusBecomes(({ referee }) => referee.game_is_running);
    await ask('POST', '/match-log', { record: false });
    assert.match((await isNow('recording')).match_log.name, /Third_team/);
  });

  it('that somebody ended by hand do not begin again in the same match', async () => {
    said = { ...TEAMS, stage: 1, command: START };
    await isNow('recording');
    await ask('POST', '/match-log', { record: false });
    const count = (await logs()).length;
    // The match continues, and the service receives that.
    said = { ...said, yellow: ['TIGERs Mannheim', undefined, 1] };
    await service.statusBecomes(({ referee }) => referee.match.score.yellow === 1);
    said = { ...TEAMS, stage: 2, command: 0 };
    await service.statusBecomes(({ referee }) => referee.match.stage === 'half_time');
    const left = await state();
    assert.deepEqual([left.state, left.error], ['left_out', '127.0.0.1 stopped its log']);
    assert.match(ctl('match-log', 'list'), /^match log: left_out: 127\.0\.0\.1 stopped its log$/m);
    assert.equal((await logs()).length, count);
    const isTold = (isThere) => service.statusBecomes(({ alerts }) => alerts.some(({ id }) => id === 'recording_stopped') === isThere);
    const { alerts, checks } = await isTold(true);
    assert.equal(alerts.find(({ id }) => id === 'recording_stopped').title, 'This match is not recorded: 127.0.0.1 stopped its log');
    assert.deepEqual(checks.filter(({ id }) => id === 'recording').map(({ state: how, text }) => [how, text]), [['warn', 'This match is not recorded: 127.0.0.1 stopped its log']]);
    // Records the rest of the match by hand.
    await ask('POST', '/match-log', { record: true });
    await isTold(false);
    await ask('POST', '/match-log', { record: false });
    await isTold(true);
    said = { ...TEAMS, yellow: ['Another team'], stage: 1, command: START };
    await isNow('recording');
    await isTold(false);
  });

  it('are pinned and deleted', async () => {
    const [{ name }] = await logs();
    assert.equal((await ask('PATCH', `/logs/${name}`, { pinned: true })).json.logs[0].pinned, true);
    assert.equal((await ask('PATCH', `/logs/${name}`, { pinned: 'yes' })).status, 400);
    assert.equal((await ask('PATCH', `/logs/${name}`, { pinned: false })).json.logs[0].pinned, false);
    assert.ok(!(await ask('DELETE', `/logs/${name}`)).json.logs.some((log) => log.name === name));
    assert.ok(!readdirSync(folder).some((file) => file.startsWith(name)), 'nothing of it is left');
    assert.equal((await ask('DELETE', `/logs/${name}`)).status, 404);
  });

  it('cannot be addressed outside their folder', async () => {
    writeFileSync(join(service.stateFolder, 'secret.log'), 'SSL_LOG_FILE');
    for (const name of ['..%2fsecret.log', '%2e%2e%2fsecret.log', '..%2f..%2fadmin.json', '.log', 'x.txt', encodeURIComponent('ä.log')]) {
      for (const method of ['GET', 'PATCH', 'DELETE']) assert.equal((await ask(method, `/logs/${name}`, method === 'GET' ? undefined : { pinned: true })).status, 404, `${method} ${name}`);
    }
    for (const name of ['../x', '', 'a/b', 'ä', 'x'.repeat(101), 7, null])
      assert.equal((await ask('POST', '/match-log', { record: true, name })).status, 400, JSON.stringify(name));
    assert.ok(existsSync(join(service.stateFolder, 'secret.log')));
  });

  it('keep what was written when the service is killed', async () => {
    await ask('POST', '/match-log', { record: true, name: 'killed' });
    const { name } = await state();
    await becomes(state, ({ messages, bytes }) => messages.vision > 40 && bytes > 1000);
    // Waits for two writes after this count: the first one may have begun before these messages arrived.
    const { messages: { vision: sure }, bytes } = await state();
    const { bytes: first } = await becomes(state, (now) => now.bytes > bytes);
    await becomes(state, (now) => now.bytes > first);
    process.kill(service.pid(), 'SIGKILL');
    await becomes(async () => { try { return process.kill(service.pid(), 0); } catch { return false; } }, (runs) => !runs);
    await service.start();
    const log = await newestIsRead();
    assert.equal(log.name, name);
    assert.equal(log.problem, '');
    const messages = messagesOf(readFileSync(join(folder, name)));
    assert.ok(ofType(messages, VISION).length >= sure, `${ofType(messages, VISION).length} of ${sure} detections that were written`);
    assert.ok(!existsSync(join(folder, `${name}.unfinished`)));
  });

  it('of other programs are read, and invalid files say why', async () => {
    mkdirSync(folder, { recursive: true });
    writeFileSync(join(folder, '2000-01-01_ours.log'), Buffer.concat([Buffer.from('SSL_LOG_FILE\0\0\0\x01', 'latin1'), Buffer.from([0, 0, 0, 0, 0x3b, 0x9a, 0xca, 0, 0, 0, 0, 4, 0, 0, 0, 2, 1, 2])]));
    writeFileSync(join(folder, '2000-01-02_no_log.log.gz'), 'no log');
    const all = await becomes(logs, (now) => now.filter(({ name }) => name.startsWith('2000')).every(({ seconds, problem }) => seconds !== null || problem !== ''));
    const [none, ours] = ['2000-01-02_no_log.log.gz', '2000-01-01_ours.log'].map((name) => all.find((log) => log.name === name));
    assert.match(none.problem, /is not a log of the league: it does not begin with SSL_LOG_FILE/);
    assert.deepEqual([ours.problem, ours.begin_s, ours.seconds, ours.messages.vision], ['', 1, 0, 1]);
    assert.equal((await ask('GET', `/logs/${none.name}/events`)).status, 422);
  });

  it('are shown, converted and played by the command line', async () => {
    const file = join(folder, (await ask('POST', '/match-log', { record: true, name: 'tools' })).json.match_log.name);
    await becomes(state, ({ messages }) => messages.vision > 20 && messages.tracked > 20);
    assert.match(ctl('match-log', 'list'), /^match log: recording \S+_tools\.log\.gz, /);
    assert.equal(ctl('match-log', 'stop'), '');
    const messages = messagesOf(readFileSync(file));
    const info = JSON.parse(ctl('match-log', 'info', '--json', file));
    assert.equal(info.messages.vision, ofType(messages, VISION).length);
    assert.match(ctl('match-log', 'info', file), new RegExp(` ${info.messages.tracked} {2}tracked messages`));

    // Convert to a plain file with the league's index, and pack it again.
    const plain = join(service.folder, 'plain.log'), packed = join(service.folder, 'packed.log.gz');
    assert.equal(ctl('match-log', 'convert', file, plain), `${messages.length} messages\n`);
    const bytes = readFileSync(plain);
    assert.equal(bytes.toString('latin1', bytes.length - 7), 'INDEXED');
    const index = bytes.length - Number(bytes.readBigInt64BE(bytes.length - 15));
    assert.deepEqual([Number(bytes.readBigInt64BE(index)), bytes.readInt32BE(index + 8), bytes.readInt32BE(index + 12)], [0, 6, 8 * messages.length + 15]);
    messages.forEach((message, i) => {
      const at = Number(bytes.readBigInt64BE(index + 16 + 8 * i));
      assert.equal(bytes.readInt32BE(at + 8), message.type);
      assert.deepEqual(bytes.subarray(at + 16, at + 16 + bytes.readInt32BE(at + 12)), message.bytes);
    });
    ctl('match-log', 'convert', plain, packed);
    assert.deepEqual(gunzipSync(readFileSync(packed)), gunzipSync(readFileSync(file)));
    assert.throws(() => ctl('match-log', 'convert', plain, packed), /already exists/);

    // Plays to a group other than the teams'.
    const group = '239.255.77.98', port = await freeUdpPort();
    assert.throws(() => ctl('match-log', 'play', file, '--group', '224.5.23.2'), /teams listen to 224\.5\.23\.2/);
    const heard = [];
    const ears = await listenTo(group, port, (packet) => heard.push(packet));
    await promisify(execFile)(CTL, ['match-log', 'play', file, '--speed', '16', '--group', group, '--vision-port', String(port), '--interface', 'lo']);
    await becomes(() => heard.length, (count) => count >= info.messages.vision);
    ears.close();
    assert.deepEqual(heard, ofType(messages, VISION).map((message) => message.bytes));
  });

  it('are not crowded out by what strangers send', async () => {
    // Three older logs that almost fill the quota; one is pinned.
    mkdirSync(folder, { recursive: true });
    for (const { name } of await logs()) await ask('DELETE', `/logs/${name}`);
    const older = ['2001-01-01_a.log', '2001-01-02_b.log', '2001-01-03_c.log'];
    for (const name of older) {
      writeFileSync(join(folder, name), Buffer.from('SSL_LOG_FILE\0\0\0\x01', 'latin1'));
      truncateSync(join(folder, name), 2_800_000);
    }
    await ask('PATCH', `/logs/${older[0]}`, { pinned: true });
    await service.patch({ op: 'add', path: '/recording', value: { match_logs: 'by_game_controller', quota_mb: 10, keep_free_mb: 0, last_seconds: { memory_mb: 0 } } });
    said = { ...TEAMS, stage: 1, command: START };
    const { name } = (await isNow('recording')).match_log;
    const tracked = (await state()).messages.tracked;
    const noise = Buffer.from(Array.from({ length: 1400 }, (_, i) => ((i * 197 + 31) % 251) | 1));
    // Sends until 14 MB have arrived, more than the quota: the kernel drops packets if the service reads too slowly.
    for (let number = 0; (await state()).refused < 10_000;) {
      for (let i = 0; i < 100; i++, number++) {
        noise.writeUInt32LE(Math.imul(number, 2654435761) >>> 0, (number * 13) % 1390);
        gc.send(noise, service.settings.network.tracker.port, TRACKER_GROUP);
      }
      for (const [port, group] of [[service.settings.network.tracker.port, TRACKER_GROUP], [service.settings.network.vision.port, GROUP], [gcPort, GC_GROUP]]) gc.send(Buffer.alloc(0), port, group);
    }
    await becomes(state, ({ messages }) => messages.tracked > tracked + 30);
    const { bytes, lost } = await state();
    assert.ok(bytes < 1_500_000, `${bytes} bytes of a few seconds`);
    assert.equal(lost, 0);
    const { alerts } = await service.statusBecomes(({ alerts: now }) => now.some(({ id }) => id === 'recording_refused'));
    assert.equal(alerts.filter(({ id }) => id.startsWith('recording_')).length, 1);
    assert.match(alerts.find(({ id }) => id === 'recording_refused').title, /^The match log drops \d+ datagrams /);
    assert.deepEqual((await logs()).map((log) => log.name).sort(), [...older, name]);

    // With so little space left, strangers' valid messages may not take more of the log than our own.
    let frame = 0;
    const flood = setInterval(() => {
      for (let i = 0; i < 20; i++) gc.send(strangersTracks({ uuid: 'stranger'.repeat(150), frame: ++frame }), service.settings.network.tracker.port, TRACKER_GROUP);
    }, 10);
    try {
      await service.statusBecomes(({ alerts: now }) => now.some(({ id }) => id === 'recording_cut'));
    } finally {
      clearInterval(flood);
    }
    assert.ok((await state()).messages.tracked > tracked + 30);
    assert.deepEqual((await logs()).map((log) => log.name).sort(), [...older, name]);

    // Pinned logs fill the quota: the match is recorded to its end, and the recording is kept.
    for (const log of older) {
      truncateSync(join(folder, log), 3_400_000);
      await ask('PATCH', `/logs/${log}`, { pinned: true });
    }
    const full = await service.statusBecomes(({ alerts: now }) => now.some(({ id }) => id === 'recording_disk'));
    assert.match(full.alerts.find(({ id }) => id === 'recording_disk').title, /^Too much is kept: recordings take 1\d MB, and may take 10 MB \(\/recording\/quota_mb\)/);
    assert.equal((await state()).state, 'recording');
    said = { ...TEAMS, stage: 13, command: 0 };
    await isNow('waiting');
    // Wait until the disk has been checked again.
    truncateSync(join(folder, older[0]), 8_400_000);
    await service.statusBecomes(({ alerts: now }) => now.some(({ id, title }) => id === 'recording_disk' && title.includes('recordings take 15 MB')));
    assert.deepEqual((await logs()).map((log) => log.name).sort(), [...older, name]);
    const text = await (await fetch(service.address('api/events'))).text();
    assert.ok(!text.includes('was removed to make room'), text);
    assert.ok(existsSync(join(folder, name)));
    for (const log of older) await ask('DELETE', `/logs/${log}`);
  });

  it('are kept even if the disk has less free space than required', async () => {
    const before = (await logs()).length;
    assert.ok(before > 0);
    await service.patch({ op: 'add', path: '/recording', value: { match_logs: 'by_hand', quota_mb: 1000, keep_free_mb: 10_000_000 } });
    await service.statusBecomes(({ alerts }) => alerts.some(({ id }) => id === 'recording_disk'));
    assert.equal((await logs()).length, before);
  });

  it('are refused with a reason if the disk has too little free space', async () => {
    await service.patch({ op: 'add', path: '/recording', value: { match_logs: 'by_game_controller', quota_mb: 10, keep_free_mb: 10_000_000 } });
    const refused = await ask('POST', '/match-log', { record: true });
    assert.equal(refused.status, 507);
    assert.match(refused.json.error, /GB of the disk are free; recordings leave 10000\.0 GB \(\/recording\/keep_free_mb\)/);
    said = { ...TEAMS, stage: 1, command: START };
    const { match_log } = await isNow('failed');
    assert.match(match_log.error, /keep_free_mb/);
    const { alerts, checks } = await service.statusBecomes(({ alerts: now }) => now.some(({ id }) => id === 'recording_failed'));
    const alert = alerts.find(({ id }) => id === 'recording_failed');
    assert.equal(alert.severity, 'warn');
    assert.equal(checks.find(({ id }) => id === 'recording').state, 'warn');
  });
});
