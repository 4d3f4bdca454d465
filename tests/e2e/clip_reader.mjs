// SPDX-License-Identifier: Apache-2.0
// Reads clips. Written from docs/recording.md alone, so that tests check the description against what the service
// writes.
import { readFileSync } from 'node:fs';

const table = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

/** CRC-32 as in gzip. */
export function crc32(bytes) {
  let sum = 0xffffffff;
  for (const byte of bytes) sum = table[(sum ^ byte) & 0xff] ^ (sum >>> 8);
  return (sum ^ 0xffffffff) >>> 0;
}

const kFormats = ['uyvy', 'yuyv', 'rgb24', 'bgr24', 'mono8', 'bayer_rg8', 'bayer_gr8', 'bayer_gb8', 'bayer_bg8'];
const bytesPerPixel = (format) => (format < 2 ? 2 : format < 4 ? 3 : 1);
const kHead = Buffer.from([0x89, 0x53, 0x53, 0x4c, 0x5f, 0x43, 0x4c, 0x49, 0x50, 0x0d, 0x0a, 0x1a, 1, 0, 0, 0]);

function check(holds, what) {
  if (!holds) throw new Error(what);
}
const u64 = (bytes, place) => Number(bytes.readBigUInt64LE(place));

/** The block at an offset of the file, with its checksums verified. */
function blockAt(file, place) {
  const head = file.subarray(place, place + 32);
  check(head.length === 32 && head.readUInt32LE(28) === crc32(head.subarray(0, 28)), `block at ${place}: damaged head`);
  const bytes = u64(head, 8);
  check(bytes <= file.length - place - 32, `block at ${place}: longer than the file`);
  const payload = file.subarray(place + 32, place + 32 + bytes);
  check(head.readUInt32LE(24) === crc32(payload), `block at ${place}: damaged payload`);
  const end = place + 32 + Math.ceil(bytes / 8) * 8;
  check(file.subarray(place + 32 + bytes, end).every((byte) => byte === 0), `block at ${place}: what fills it up is not 0`);
  return { place, end, type: head.readUInt32LE(0), camera_id: head.readUInt32LE(4), bytes, time_ns: head.readBigInt64LE(16), payload };
}

function frameOf(block) {
  const at = block.payload;
  check(at.length >= 128 && at.readUInt32LE(124) === crc32(at.subarray(0, 124)), `block at ${block.place}: damaged frame`);
  const flags = at.readUInt32LE(32), format = at.readUInt32LE(36);
  check(format < kFormats.length, `block at ${block.place}: unknown pixel format ${format}`);
  check([at.subarray(64, 72), at.subarray(88, 96), at.subarray(104, 124)].every((part) => part.every((byte) => byte === 0)), `block at ${block.place}: what is 0 is not`);
  const frame = {
    camera_id: block.camera_id, number: at.readUInt32LE(0), setup: at.readUInt32LE(4), t_capture_s: at.readDoubleLE(8),
    t_capture_camera_s: flags & 1 ? at.readDoubleLE(16) : null, t_capture_sigma_s: flags & 2 ? at.readDoubleLE(24) : null,
    is_by_ptp: (flags & 4) !== 0, is_deep: (flags & 8) !== 0, pixel_format: kFormats[format], pixel_bytes: bytesPerPixel(format),
    width: at.readUInt32LE(40), height: at.readUInt32LE(44),
    whole: { width: at.readUInt32LE(48), height: at.readUInt32LE(52), x: at.readUInt32LE(56), y: at.readUInt32LE(60) },
    image: null,
  };
  let place = 128;
  const next = (bytes) => at.subarray(place, (place += bytes));
  frame.packet = next(u64(at, 72));
  frame.memory = next(u64(at, 80));
  const image = next(u64(at, 96));
  check(place === at.length, `frame ${frame.number}: its parts are ${place} bytes, not ${at.length}`);
  const bytes = frame.width * frame.height * frame.pixel_bytes * (frame.is_deep ? 2 : 1);
  check(image.length === bytes, `frame ${frame.number}: its image is ${image.length} bytes, not ${bytes}`);
  if (bytes > 0) frame.image = image;
  return frame;
}

/**
 * Reads a whole clip: {is_finished, about, setups: [{camera_id, about, table}], events, frames, missing: {camera_id:
 * frames}}. Frames are in file order and have camera_id, number, t_capture_s, pixel_format, width, height, setup,
 * packet, memory and image (null: none). Throws an Error if the file is no clip or damaged; an unfinished clip ends
 * with its last complete block.
 */
export function readClip(path) {
  const file = readFileSync(path);
  check(file.length >= 16 && file.subarray(0, 12).equals(kHead.subarray(0, 12)), `${path}: is no clip`);
  check(file.subarray(0, 16).equals(kHead), `${path}: version ${file.readUInt32LE(12)} is not known`);
  const isFinished = file.length >= 64 && file.subarray(-8).toString('latin1') === 'SSL_CEND';
  const end = isFinished ? file.length - 16 : file.length;
  const out = { is_finished: isFinished, about: null, setups: [], events: [], frames: [], missing: {} };
  const lines = [];
  const isWhole = (place) => place + 32 <= end && u64(file, place + 8) <= end - place - 32;
  let index = null;
  for (let place = 16; isFinished ? place < end : isWhole(place);) {
    check(index === null, `${path}: blocks behind the index`);
    const block = blockAt(file, place);
    const text = (bytes) => JSON.parse(bytes.toString('utf8'));
    const line = { place, bytes: block.bytes, t_capture_s: 0, type: block.type, camera_id: block.camera_id, number: 0, flags: 0 };
    if (block.type === 1) out.about = text(block.payload);
    if (block.type === 2) {
      const jsonEnd = 16 + u64(block.payload, 8);
      line.number = block.payload.readUInt32LE(0);
      out.setups[line.number] = { camera_id: block.camera_id, about: text(block.payload.subarray(16, jsonEnd)), table: block.payload.subarray(jsonEnd) };
    }
    if (block.type === 3) {
      const frame = frameOf(block);
      check(frame.setup in out.setups, `${path}: frame ${frame.number} comes before its setup`);
      line.t_capture_s = frame.t_capture_s;
      line.number = frame.number;
      line.flags = (frame.memory.length > 0 ? 1 : 0) | (frame.image !== null ? 2 : 0);
      out.frames.push(frame);
    }
    if (block.type === 4) out.events.push(text(block.payload));
    if (block.type === 5) out.missing[block.camera_id] = (out.missing[block.camera_id] ?? 0) + u64(block.payload, 0);
    if (block.type === 6) index = block;
    else lines.push(line);
    place = block.end;
  }
  if (!isFinished) return out;
  check(index !== null && u64(file, end) === index.place, `${path}: the trailer does not name the index`);
  check(index.payload.length === 40 * lines.length, `${path}: the index has ${index.payload.length / 40} lines, not ${lines.length}`);
  lines.forEach((line, i) => {
    const at = index.payload.subarray(40 * i, 40 * i + 40);
    const said = { place: u64(at, 0), bytes: u64(at, 8), t_capture_s: at.readDoubleLE(16), type: at.readUInt32LE(24), camera_id: at.readUInt32LE(28),
      number: at.readUInt32LE(32), flags: at.readUInt32LE(36) };
    check(JSON.stringify(said) === JSON.stringify(line), `${path}: line ${i} of the index is ${JSON.stringify(said)}, not ${JSON.stringify(line)}`);
  });
  return out;
}
