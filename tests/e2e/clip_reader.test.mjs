// SPDX-License-Identifier: Apache-2.0
// The clip format: a reader written from docs/recording.md reads a clip written by the service's own code (the unit
// test Clip.IsWrittenAsItWasDescribed), and damaged clips.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, it } from 'node:test';
import { fileURLToPath } from 'node:url';
import { crc32, readClip } from './clip_reader.mjs';

const golden = fileURLToPath(new URL('../golden/small.clip', import.meta.url));
const folder = mkdtempSync(join(tmpdir(), 'sslv_clip_'));
after(() => rmSync(folder, { recursive: true }));

/** The noise of tests/support/clip_images.h: all pixels row by row, then all low bits. */
function noise(pixelBytes, width, height, seed, padding, isDeep) {
  const stride = width * pixelBytes + padding, planes = isDeep ? 2 : 1;
  let state = (Math.imul(seed, 2654435761) + 1) >>> 0;
  const bytes = Buffer.alloc(stride * height * planes);
  for (let i = 0; i < bytes.length; i++) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    bytes[i] = state >>> 24;
  }
  const rows = [];
  for (let y = 0; y < height * planes; y++) rows.push(bytes.subarray(y * stride, y * stride + width * pixelBytes));
  return Buffer.concat(rows);
}

it('gives back all that the service wrote', () => {
  const clip = readClip(golden);
  assert.equal(clip.is_finished, true);
  assert.deepEqual(clip.about, { format: 'ssl-visiond clip', site: 'Halle 3', version: '1.2', kind: 'kept', why: 'kept by hand', begin_s: 1000, end_s: 1012 });
  assert.deepEqual(clip.setups.map((one) => [one.camera_id, one.about, one.table.toString()]), [[0, { settings: { gain: 3 } }, 'a table'], [7, { patterns: null }, '']]);
  assert.deepEqual(clip.events, [{ time_s: 1000.02, kind: 'goal', text: 'Yellow, 1:0' }]);
  assert.deepEqual(clip.missing, { 7: 5 });
  assert.equal(clip.frames.length, 12);
  clip.frames.forEach((frame, k) => {
    const i = Math.floor(k / 2), id = k % 2 === 0 ? 0 : 7, isDeep = id === 7;
    assert.deepEqual([frame.camera_id, frame.number, frame.setup], [id, 100 + i, isDeep ? 1 : 0]);
    assert.equal(frame.t_capture_s, 1000 + i * 0.0125 + id * 0.001);
    assert.equal(frame.t_capture_camera_s, isDeep ? i * 0.0125 : null);
    assert.equal(frame.t_capture_sigma_s, i % 2 === 0 ? 1e-5 : null);
    assert.equal(frame.is_by_ptp, i === 3);
    assert.deepEqual(frame.whole, isDeep ? { width: 0, height: 0, x: 0, y: 0 } : { width: 64, height: 48, x: 32, y: 6 });
    assert.deepEqual([frame.pixel_format, frame.width, frame.height, frame.is_deep], [isDeep ? 'uyvy' : 'bayer_rg8', 18, 10, isDeep]);
    assert.equal(frame.packet.toString(), i === 2 ? '' : `packet ${i}`);
    assert.equal(frame.memory.toString(), i % 2 === 1 ? 'm'.repeat(30 * i) : '');
    const pixelBytes = isDeep ? 2 : 1, pixels = noise(pixelBytes, 18, 10, i * 10 + id, isDeep ? 3 : 0, isDeep);
    assert.ok(frame.image.equals(pixels), `frame ${i} of camera ${id}`);
  });
});

it('reads an unfinished clip as far as it goes', () => {
  const bytes = readFileSync(golden), path = join(folder, 'cut.clip');
  for (const length of [16, 17, 100, 1000, bytes.length - 1, bytes.length - 16]) {
    writeFileSync(path, bytes.subarray(0, length));
    const clip = readClip(path);
    assert.equal(clip.is_finished, false);
    assert.ok(clip.frames.length <= 12);
    if (length > bytes.length - 20) assert.equal(clip.frames.length, 12);
  }
});

it('refuses what is damaged or no clip', () => {
  const bytes = readFileSync(golden), path = join(folder, 'bad.clip');
  for (let place = 0; place < bytes.length - 16; place += 7) {
    const bad = Buffer.from(bytes);
    bad[place] ^= 0x10;
    writeFileSync(path, bad);
    assert.throws(() => readClip(path), Error, `byte ${place}`);
  }
  writeFileSync(path, 'no clip at all, but a text');
  assert.throws(() => readClip(path), /is no clip/);
  assert.equal(crc32(Buffer.from('123456789')), 0xcbf43926);
});
