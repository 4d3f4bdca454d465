// SPDX-License-Identifier: Apache-2.0
// Clips from outside: the real service, its packets on the network, and a reader that is written from the format's
// description (docs/recording.md) instead of the service's code.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { existsSync, mkdirSync, readdirSync, readFileSync, rmSync, symlinkSync, truncateSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, beforeEach, describe, it } from 'node:test';
import { readClip } from './clip_reader.mjs';
import { gameController } from './league_messages.mjs';
import { becomes, createService, freeUdpPort, listenTo, root } from './service.mjs';

const GROUP = '239.255.77.92', GC_GROUP = '239.255.77.93';
const service = await createService(GROUP);
const gcPort = await freeUdpPort();
service.settings.network.referee = { enabled: true, group: GC_GROUP, port: gcPort, interface: 'lo' };
// Two cameras with small images, so that seconds fit into little memory.
const [first] = service.settings.cameras;
service.settings.cameras = [0, 1].map((id) => ({ ...structuredClone(first), id, source: { ...structuredClone(first.source), frame_rate_hz: 10 } }));
service.settings.panel.match_lock = false; // settings change during play
service.settings.recording = { last_seconds: { memory_mb: 150 }, clips: { seconds: 3, seconds_after: 0.5 } };
const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const ctl = (...words) => execFileSync(CTL, ['--daemon', service.address('').slice(0, -1), ...words], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
const folder = join(service.stateFolder, 'recordings');

const ask = async (method, path, body) => {
  const answer = await fetch(service.address(`api/recordings${path}`), { method, body: body && JSON.stringify(body) });
  const text = await answer.text();
  return { status: answer.status, json: answer.headers.get('content-type')?.includes('json') ? JSON.parse(text) : null, text };
};
const clips = async () => (await ask('GET', '/clips')).json;
/** Waits until each camera has so many seconds in memory. */
const reaches = (seconds) => becomes(clips, ({ last_seconds: { cameras } }) => cameras.length === 2 && cameras.every((camera) => camera.seconds >= seconds));
/** Requests a clip as soon as none is being written. */
async function begins(body) {
  const answer = await becomes(() => ask('POST', '/clips', body), ({ status }) => status !== 409);
  assert.equal(answer.status, 202, answer.text);
}
/** Requests a clip and waits until the service has indexed it. */
async function clipWith(body, name) {
  await begins({ name, ...body });
  return isThere(name);
}
const isThere = async (name) => {
  const isRead = (clip) => clip.name.endsWith(`_${name}.clip`) && clip.begin_s !== null;
  return (await becomes(clips, ({ clip, clips: all }) => clip.state === 'idle' && all.some(isRead))).clips.find(isRead);
};
const pathOf = ({ name }) => join(folder, name);

describe('clips', () => {
  before(() => service.start());
  beforeEach(() => service.restore());
  after(() => service.end());

  it('hold the sent packets byte for byte, according to an independent reader', async () => {
    const heard = new Set();
    const ears = await listenTo(GROUP, service.settings.network.vision.port, (packet) => heard.add(packet.toString('latin1')));
    await becomes(() => heard.size, (count) => count > 20);
    await reaches(3);
    const made = await clipWith({ seconds: 2 }, 'sent');
    ears.close();
    assert.ok(made.seconds > 1.8, `${made.seconds}`);

    const clip = readClip(pathOf(made));
    assert.match(clip.about.why, /^kept by hand/);
    assert.equal(clip.about.kind, 'kept');
    assert.equal(clip.frames.length, made.cameras[0].frames + made.cameras[1].frames);
    let unheard = 0;
    for (const { id, frames: count, missing } of made.cameras) {
      const frames = clip.frames.filter(({ camera_id }) => camera_id === id);
      assert.equal(frames.length, count);
      const gaps = frames.slice(1).reduce((sum, { number }, i) => sum + number - frames[i].number - 1, 0);
      assert.ok(gaps <= missing, `${gaps} frames are not there, ${missing} are said to be missing`);
      assert.ok(frames[0].memory.length > 0, 'it begins with what the stages remember');
      assert.ok(frames.every(({ image, width, height }) => image.length >= width * height));
      // The first packets may have been sent before the listener was ready.
      const wasHeard = frames.map(({ packet }) => heard.has(packet.toString('latin1')));
      assert.ok(wasHeard.includes(true));
      unheard += wasHeard.slice(wasHeard.indexOf(true)).filter((was) => !was).length;
    }
    assert.ok(unheard <= ears.missed(), `${unheard} of these packets were not sent`);
    const settings = clip.setups[0].about.settings;
    assert.equal(settings.cameras.length, 1);
    assert.equal(settings.site, service.settings.site ?? settings.site);
  });

  it('give the same bytes again, also over a change of settings and of the light', async () => {
    await reaches(1);
    await begins({ seconds: 1, seconds_after: 100, name: 'same' });
    assert.equal((await ask('POST', '/clips', {})).status, 409, 'one at a time');
    await service.patch({ op: 'replace', path: '/cameras/0/stages/detect_balls/min_confidence', value: 0.3 });
    await service.patch({ op: 'replace', path: '/cameras/1/colors/bits', value: 6 });
    // The service stops while writing the clip, after the new settings are in it.
    const { clip: { name } } = await becomes(clips, ({ clip }) => clip.name.endsWith('_same.clip') && clip.frames > 0);
    await becomes(() => readClip(join(folder, name)).setups.length, (count) => count >= 4);
    await service.stop();
    await service.start();
    const made = await isThere('same');
    const told = execFileSync(CTL, ['replay', pathOf(made), '--compare', '--json'], { encoding: 'utf8' });
    const result = JSON.parse(told);
    assert.match(JSON.stringify(result), /"frames_with_other_bytes":\s*0/);
    assert.doesNotMatch(JSON.stringify(result), /"frames_with_other_bytes":\s*[1-9]/);

    // The same through the panel's route.
    assert.equal((await ask('POST', `/clips/${made.name}/compare`, { camera: 1, with: 'recorded_settings' })).status, 202);
    const same = await becomes(async () => (await ask('GET', '/compare')).json, ({ state }) => state !== 'running');
    assert.equal(same.state, 'done', same.error);
    assert.deepEqual({ ...same.result, frames: 0, largest_mm: 0 }, {
      exact: true, why_not_exact: '', frames: 0, frames_that_differ: 0, frames_with_other_bytes: 0, found: 0, lost: 0, moved: 0, id_changed: 0, largest_mm: 0, threshold_mm: 1, differences: [],
    });
    assert.equal(same.result.frames, made.cameras[1].frames);
  });

  it('show what other settings would find', async () => {
    await reaches(1);
    const made = await clipWith({ seconds: 1 }, 'other');
    await service.patch({ op: 'replace', path: '/cameras/0/stages/detect_robots/min_confidence', value: 1 });
    assert.equal((await ask('POST', `/clips/${made.name}/compare`, { with: 'settings_now' })).status, 202);
    const { state, result, error } = await becomes(async () => (await ask('GET', '/compare')).json, (now) => now.state !== 'running');
    assert.equal(state, 'done', error);
    assert.ok(result.lost > 0 && result.found === 0, JSON.stringify({ ...result, differences: [] }));
    const [difference] = result.differences;
    assert.equal(difference.kind, 'lost');
    assert.match(difference.what, /^(yellow|blue) \d+$/);
    const frame = (await ask('GET', `/clips/${made.name}/frames/${difference.place}`)).json;
    assert.ok(frame.robots.some(({ team, id, pixel_x }) => `${team} ${id}` === difference.what && Math.abs(pixel_x - difference.pixel_x) < 1));
    assert.equal((await ask('POST', `/clips/${made.name}/compare`, { with: 'learnt_colors' })).status, 409);
    assert.equal((await ask('POST', `/clips/${made.name}/compare`, { with: 'x' })).status, 400);
    assert.equal((await ask('POST', `/clips/${made.name}/compare`, { camera: 7 })).status, 400);
  });

  it('are shown frame by frame', async () => {
    await reaches(1);
    const made = await clipWith({ seconds: 1 }, 'shown');
    const { json: index } = await ask('GET', `/clips/${made.name}/frames`);
    assert.deepEqual(index.cameras.map(({ id, places }) => [id, places.length]), made.cameras.map(({ id, frames }) => [id, frames]));
    const place = index.cameras[1].places[3];
    const { json: frame } = await ask('GET', `/clips/${made.name}/frames/${place}`);
    assert.equal(frame.camera, 1);
    assert.equal(frame.number, index.cameras[1].numbers[3]);
    assert.ok(Math.abs(frame.time_s - index.cameras[1].times_s[3]) < 1e-6);
    const picture = await fetch(service.address(`api/recordings/clips/${made.name}/frames/${place}/picture?width=200`));
    assert.equal(picture.headers.get('content-type'), 'image/jpeg');
    assert.ok((await picture.arrayBuffer()).byteLength > 1000);
    assert.equal((await ask('GET', `/clips/${made.name}/frames/999999`)).status, 404);
    for (const name of ['..%2Fadmin.json', 'none.clip', '.clip']) assert.equal((await ask('GET', `/clips/${name}/frames`)).status, 404, name);
  });

  it('give their frames to other tools, which find the same in them', async () => {
    await reaches(1);
    const made = await clipWith({ seconds: 1 }, 'export');
    const out = join(service.folder, 'frames'), one = join(out, 'camera_1'), settings = join(service.folder, 'now.json');
    ctl('clip', 'export', pathOf(made), '--output', out, '--format', 'raw');
    writeFileSync(settings, ctl('settings', 'export'));
    // frames.json beside the frames describes their format.
    ctl('process', '--settings', settings, '--camera', '1', '--input', one, '--output', join(out, 'found.jsonl'));
    assert.equal(readFileSync(join(out, 'found.jsonl'), 'utf8').trim().split('\n').length, made.cameras[1].frames);
    ctl('score', '--detections', join(out, 'found.jsonl'), '--truth', join(one, 'truth.jsonl'), '--min-robot-share', '0.95');
    ctl('learn-colours', '--settings', settings, '--camera', '1', '--input', one, '--output', join(out, 'learnt.lut'));
    assert.ok(existsSync(join(out, 'learnt.lut')));
  });

  it('may be a camera', async () => {
    await reaches(1);
    const made = await clipWith({ seconds: 1 }, 'camera');
    writeFileSync(join(service.folder, 'shown.clip'), '');
    const show = execFileSync('cp', [pathOf(made), join(service.folder, 'shown.clip')]);
    assert.equal(show.length, 0);
    await service.patch({ op: 'replace', path: '/cameras/0/source', value: { backend: 'files', path: join(service.folder, 'shown.clip'), camera_id: 0, loop: true } });
    await service.statusBecomes(({ cameras: [one] }) => one.state === 'running' && one.backend === 'files' && one.robots > 0 && one.frames > 0);
  });

  it('are made at a goal and at a command when the settings say so', async () => {
    await reaches(1);
    await service.patch({ op: 'replace', path: '/recording/clips/on_goal', value: true });
    const gc = createSocket('udp4');
    gc.bind(0, '127.0.0.1');
    await once(gc, 'listening');
    gc.setMulticastInterface('127.0.0.1');
    // A goal and another command every second.
    let said = 0;
    const talking = setInterval(() => {
      const second = Math.floor(said++ / 10);
      gc.send(gameController({ yellow: ['A', undefined, second], blue: ['B', undefined, 0], stage: 1, command: second % 2 ? 3 : 1 }), gcPort, GC_GROUP);
    }, 100);
    try {
      const goal = await isThere('goal');
      await service.patch({ op: 'replace', path: '/recording/clips/on_goal', value: false }, { op: 'replace', path: '/recording/clips/on_command', value: true });
      assert.match(goal.why, /^Goal for yellow: \d+ : 0$/);
      assert.equal(readClip(pathOf(goal)).about.kind, 'goal');
      assert.ok(readClip(pathOf(goal)).events.some(({ kind, text }) => kind === 'goal' && text === goal.why));
      assert.match((await isThere('command')).why, /^(Stop|Force start)$/);
      await service.patch({ op: 'replace', path: '/recording/clips/on_command', value: false });
      // A clip that is kept without a name gets that of the last event in it, if there is one.
      const isKept = ({ why, begin_s }) => why.startsWith('kept by hand after: ') && begin_s !== null;
      const kept = (await becomes(async () => {
        await begins({ seconds: 3 });
        return becomes(clips, ({ clip, clips: all }) => clip.state === 'idle' && all.every(({ begin_s }) => begin_s !== null));
      }, ({ clips: all }) => all.some(isKept))).clips.find(isKept);
      assert.doesNotMatch(kept.name, /by_hand/);
    } finally {
      clearInterval(talking);
      gc.close();
    }
  });

  it('can be pinned and deleted, and respect the quota', async () => {
    await reaches(1);
    const kept = await clipWith({ seconds: 0.5 }, 'kept'), other = await clipWith({ seconds: 0.5 }, 'other_one');
    assert.equal((await ask('PATCH', `/clips/${kept.name}`, { pinned: true })).json.clips.find(({ name }) => name === kept.name).pinned, true);
    assert.equal((await ask('DELETE', `/clips/${other.name}`)).status, 200);
    assert.ok(!existsSync(pathOf(other)));
    const bytes = await fetch(service.address(`api/recordings/clips/${kept.name}`));
    assert.equal((await bytes.arrayBuffer()).byteLength, kept.bytes);
    await service.patch({ op: 'replace', path: '/recording/quota_mb', value: Math.max(10, Math.ceil(kept.bytes / 1e6) + 1) });
    await begins({ seconds: 3, name: 'too_large' });
    const failed = await becomes(clips, ({ clip }) => clip.state === 'failed');
    assert.match(failed.clip.error, /quota_mb/);
    assert.ok(!readdirSync(folder).some((file) => file.includes('too_large')), 'nothing of it is left');
    const { alerts } = await (await fetch(service.address('api/alerts'))).json();
    assert.match(alerts.find(({ id }) => id === 'clip_failed').title, /^A clip was not written: .*quota_mb/);
    assert.ok(existsSync(pathOf(kept)), 'what is pinned stays');
    await ask('PATCH', `/clips/${kept.name}`, { pinned: false });
  });

  it('are included in a support bundle on request', async () => {
    await reaches(1);
    const made = await clipWith({ seconds: 1 }, 'support');
    const answer = await fetch(service.address(`api/support?clip=${made.name}`));
    assert.equal(answer.status, 200);
    assert.equal(answer.headers.get('content-type'), 'application/x-tar');
    assert.match(answer.headers.get('content-disposition'), /^attachment; filename="ssl-visiond-.+\.tar"$/);
    const bytes = Buffer.from(await answer.arrayBuffer());
    assert.equal(bytes.length, Number(answer.headers.get('content-length')));
    const sent = join(service.folder, 'sent.tar'), saved = join(service.folder, 'saved.tar');
    writeFileSync(sent, bytes);
    ctl('support-bundle', '--clip', made.name, saved);
    const clip = await (await fetch(service.address(`api/recordings/clips/${made.name}`))).arrayBuffer();
    for (const bundle of [sent, saved]) {
      const files = execFileSync('tar', ['-tf', bundle], { encoding: 'utf8' }).trim().split('\n');
      assert.ok(files.at(-1).endsWith(`/${made.name}`), files.join());
      assert.ok(files.some((file) => file.endsWith('/status.json')));
      const unpacked = (file) => execFileSync('tar', ['-xOf', bundle, file], { maxBuffer: 1e9 });
      assert.deepEqual(unpacked(files.at(-1)), Buffer.from(clip));
      const [, what] = new RegExp(`^${made.name}: (.+)$`, 'm').exec(unpacked(files[0]).toString());
      assert.match(what, /^the cameras' images .* It shows the people on and around the field: share it only if they agree$/);
    }

    const refused = async (name) => {
      const { status } = await fetch(service.address(`api/support?clip=${name}`));
      const run = spawnSync(CTL, ['--daemon', service.address('').slice(0, -1), 'support-bundle', '--clip', decodeURIComponent(name), join(service.folder, 'refused.tar')], { encoding: 'utf8' });
      assert.ok(run.status !== 0 && !existsSync(join(service.folder, 'refused.tar')), name);
      return [status, run.stderr];
    };
    writeFileSync(join(service.stateFolder, 'secret.clip'), 'a secret');
    writeFileSync(join(folder, '2000-01-01_no_clip.log'), 'a log');
    for (const name of ['none.clip', '..%2Fsecret.clip', '%2E%2E%2F..%2Fadmin.json', '%2Fetc%2Fpasswd', '.clip', '2000-01-01_no_clip.log', `${made.name}.pinned`])
      assert.deepEqual(await refused(name), [404, 'ssl-visionctl: clip: there is no such clip\n'], name);
    assert.equal((await fetch(service.address('api/support?clip='))).status, 404);
    await begins({ seconds: 0.5, seconds_after: 60, name: 'busy' });
    const { clip: busy } = await becomes(clips, (now) => now.clip.name.endsWith('_busy.clip'));
    assert.equal((await refused(busy.name))[0], 409);
    await service.stop();
    rmSync(join(folder, busy.name), { force: true });
    await service.start();
  });

  it('are refused with a reason if the request is invalid', async () => {
    await reaches(0.5);
    for (const [body, why] of [[{ seconds: 0 }, /^\/seconds: expected a number of seconds, 0\.5 to 600$/], [{ name: '../x' }, /^\/name: expected/], [{ second: 1 }, /^\/second: is not known here/], [[], /expected an object/]]) {
      const answer = await ask('POST', '/clips', body);
      assert.equal(answer.status, 400);
      assert.match(answer.json.error, why);
    }
    mkdirSync(folder, { recursive: true });
    writeFileSync(join(folder, 'foreign.clip'), 'this is no clip, but somebody named it so');
    symlinkSync('/etc/passwd', join(folder, 'link.clip'));
    const { clips: all } = await becomes(clips, (now) => now.clips.some(({ name, problem }) => name === 'foreign.clip' && problem));
    assert.ok(!all.some(({ name }) => name === 'link.clip'));
    assert.equal((await ask('GET', '/clips/foreign.clip/frames')).status, 422);
    const foreign = join(folder, 'foreign.clip');
    for (const words of [['clip', 'info', foreign], ['clip', 'info', join(folder, 'none.clip')], ['clip', 'export', foreign, '--output', join(service.folder, 'out')], ['replay', foreign, '--compare']]) {
      const run = spawnSync(CTL, words, { encoding: 'utf8' });
      assert.deepEqual([run.status, run.stdout], [2, ''], words.join(' '));
      assert.match(run.stderr, /^ssl-visionlab: .*\.clip: /);
    }
    await service.patch({ op: 'replace', path: '/recording/last_seconds/memory_mb', value: 0 });
    await becomes(clips, ({ last_seconds }) => last_seconds.memory_bytes === 0);
    assert.match((await ask('POST', '/clips', {})).json.error, /memory_mb is 0/);
  });

  it('can be read up to the point where the service was killed', async () => {
    await reaches(2);
    await begins({ seconds: 2, seconds_after: 60, name: 'killed' });
    await becomes(clips, ({ clip }) => clip.name.endsWith('_killed.clip') && clip.frames > 60);
    process.kill(service.pid(), 'SIGKILL');
    await becomes(async () => { try { return process.kill(service.pid(), 0); } catch { return false; } }, (runs) => !runs);
    const [name] = readdirSync(folder).filter((file) => file.endsWith('_killed.clip'));
    truncateSync(join(folder, name), 30_000_001);
    const info = spawnSync(CTL, ['clip', 'info', join(folder, name)], { encoding: 'utf8' });
    assert.equal(info.status, 0, info.stderr);
    await service.start();
    const made = await isThere('killed');
    assert.match(made.problem, /was not ended/);
    const { frames } = readClip(join(folder, name));
    assert.ok(frames.length > 3);
    assert.deepEqual(made.cameras.map(({ id, frames: count }) => [id, count]), [0, 1].map((id) => [id, frames.filter(({ camera_id }) => camera_id === id).length]));
    assert.equal((await ask('GET', `/clips/${name}/frames/0/picture`)).status, 200);
  });
});
