// SPDX-License-Identifier: Apache-2.0
// Clips of images not drawn by the service's own simulator: halls from another renderer, in other pixel formats, and a
// photo if there is one (in SSLV_TEST_DATA, a folder of real data from other teams). With colours learnt from the same
// images, replays must reproduce the service's packets byte for byte, with the same results on every vector instruction
// set of the CPU.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { readClip } from './clip_reader.mjs';
import { becomes, createService, root } from './service.mjs';

const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const DRAW = process.env.SSLV_DRAW_HALLS ?? join(dirname(CTL), 'draw_halls');
const TARGETS = process.env.SSLV_TARGET_TABLE ?? join(dirname(CTL), 'target_table');
const photo = join(process.env.SSLV_TEST_DATA ?? join(root, '../shared/data'), 'real/ssl_blue6_win.jpg');

const service = await createService('239.255.77.95');
service.settings.cameras = [];
service.settings.recording = { last_seconds: { memory_mb: 300 } };

/** Adds a camera to the service that plays the images in `folder`, with these settings. */
function addCamera(folder, settings, { raw = [], everyNth, rateHz }) {
  const settingsFile = join(folder, 'settings.json'), table = join(service.folder, `table_${service.settings.cameras.length}.lut`);
  writeFileSync(settingsFile, JSON.stringify(settings));
  const [camera] = settings.cameras;
  const input = ['--settings', settingsFile, '--camera', `${camera.id}`, '--input', folder, ...raw];
  execFileSync(CTL, ['learn-colours', ...input, '--every', `${everyNth}`, '--output', table], { encoding: 'utf8' });
  service.settings.cameras.push({
    ...camera,
    id: service.settings.cameras.length,
    source: { ...camera.source, backend: 'files', path: folder, loop: true, frame_rate_hz: rateHz },
    colors: { lut_file: table },
  });
  for (const key of ['field', 'teams']) service.settings[key] = { ...service.settings[key], ...settings[key] };
}

function addHall(kind, format) {
  const folder = join(service.folder, `${kind}_${format}`);
  execFileSync(DRAW, ['--kind', kind, '--size', 'A', '--format', format, '--placement', 'paths', '--seed', '2025', '--frames', '24', '--output', folder]);
  const settings = JSON.parse(readFileSync(join(folder, 'settings.json'), 'utf8'));
  const { width, height } = settings.cameras[0].source;
  addCamera(folder, settings, { raw: ['--pixel-format', format, '--size', `${width}x${height}`], everyNth: 8, rateHz: 15 });
}

/** Requests a clip and replays it. */
async function replay(name) {
  const clips = async () => (await fetch(service.address('api/recordings/clips'))).json();
  await becomes(clips, ({ last_seconds: { cameras } }) => cameras.length > 0 && cameras.every(({ seconds }) => seconds >= 2));
  const order = await fetch(service.address('api/recordings/clips'), { method: 'POST', body: JSON.stringify({ seconds: 2, name }) });
  assert.equal(order.status, 202, await order.text());
  const { clips: all } = await becomes(clips, (now) => now.clip.state === 'idle' && now.clips.some((clip) => clip.name.endsWith(`_${name}.clip`) && clip.begin_s !== null));
  const file = join(service.stateFolder, 'recordings', all.find((clip) => clip.name.endsWith(`_${name}.clip`)).name);
  // Exit code 1: something differs.
  const targets = spawnSync(TARGETS, [file], { encoding: 'utf8' });
  assert.equal(targets.status, 0, `${targets.stdout}${targets.stderr}`);
  const again = (env) => JSON.parse(execFileSync(CTL, ['replay', file, '--compare', '--json'], { encoding: 'utf8', env: { ...process.env, ...env } }));
  // Uses the C library's math functions for CPUs without fused multiply-add (these names work in glibc 2.33 and newer).
  again({ GLIBC_TUNABLES: 'glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX512F' }).forEach(isTheSame);
  return { clip: readClip(file), told: again({}) };
}

/** Every frame was processed as it was live, with the same result as sent. */
function isTheSame({ camera, frames, exact, comparison }) {
  assert.ok(frames > 0, `camera ${camera}`);
  assert.deepEqual([exact, comparison.frames, comparison.frames_with_other_bytes], [frames, frames, 0], `camera ${camera}`);
  assert.ok(comparison.robots.before >= 5 * frames, `camera ${camera}: there is something to compare`);
}

describe('clips of images from elsewhere', () => {
  before(async () => {
    mkdirSync(service.folder, { recursive: true });
    addHall('usual', 'bayer_rg8');
    addHall('hard', 'uyvy');
    await service.start();
  });
  after(() => service.end());

  it('are the same again: halls of another renderer, Bayer and YUV', async () => {
    // Wait until all robots are detected, so that the comparison is not empty.
    await service.statusBecomes(({ cameras }) => cameras.length === 2 && cameras.every(({ robots }) => robots >= 6));
    const { clip, told } = await replay('halls');
    assert.equal(told.length, 2);
    told.forEach(isTheSame);
    assert.ok(clip.frames.every(({ packet }) => packet.length > 200), 'robots were sent');
  });

  it('are the same again: a photo', { skip: !existsSync(photo) && `no ${photo}` }, async () => {
    const folder = join(service.folder, 'photo');
    mkdirSync(folder);
    symlinkSync(photo, join(folder, 'photo.jpg'));
    const settings = JSON.parse(readFileSync(join(root, 'tests/golden/ssl_blue6.json'), 'utf8'));
    delete settings.cameras[0].colors;
    delete settings.cameras[0].stages;
    settings.cameras[0].source = { backend: 'files' };
    await service.stop();
    service.settings.cameras = [];
    addCamera(folder, settings, { everyNth: 1, rateHz: 4 });
    await service.start();
    await service.statusBecomes(({ cameras }) => cameras[0]?.robots === 6);
    const { told } = await replay('photo');
    assert.equal(told.length, 1);
    isTheSame(told[0]);
  });
});
