// SPDX-License-Identifier: Apache-2.0
// Packets of strangers, encoded by hand: the league's messages with any numbers, and GigE Vision's packets.

const varint = (value) => {
  const out = [];
  let left = BigInt.asUintN(64, BigInt(Number.isFinite(value) ? Math.trunc(value) : 0));
  while (left > 127n) {
    out.push(Number(left & 127n) | 128);
    left >>= 7n;
  }
  return Buffer.from([...out, Number(left)]);
};
const tag = (number, wire) => varint(number * 8 + wire);
export const uint = (number, value) => Buffer.concat([tag(number, 0), varint(value)]);
export const bytes = (number, value) => Buffer.concat([tag(number, 2), varint(value.length), value]);
export const text = (number, value) => bytes(number, Buffer.from(value));
export const float = (number, value) => {
  const out = Buffer.alloc(4);
  out.writeFloatLE(value);
  return Buffer.concat([tag(number, 5), out]);
};
export const double = (number, value) => {
  const out = Buffer.alloc(8);
  out.writeDoubleLE(value);
  return Buffer.concat([tag(number, 1), out]);
};
const all = (...parts) => Buffer.concat(parts.flat().filter((part) => part !== undefined));

// ---- vision

export const robot = ({ id = 0, x = 0, y = 0, orientation = 0, height = 140, confidence = 1 } = {}) =>
  all(float(1, confidence), uint(2, id), float(3, x), float(4, y), float(5, orientation), float(6, 100), float(7, 100), float(8, height));
export const ball = ({ x = 0, y = 0, z = 0, confidence = 1, area = 50 } = {}) =>
  all(float(1, confidence), uint(2, area), float(3, x), float(4, y), float(5, z), float(6, 100), float(7, 100));
export const detection = ({ frame = 1, capture = Date.now() / 1000, sent = Date.now() / 1000, camera = 20, balls = [], yellow = [], blue = [] } = {}) =>
  bytes(1, all(uint(1, frame), double(2, capture), double(3, sent), uint(4, camera),
    balls.map((one) => bytes(5, ball(one))), yellow.map((one) => bytes(6, robot(one))), blue.map((one) => bytes(7, robot(one)))));

/** A camera's pose: by default straight down, `z` above (x, y). */
export const calibration = ({ camera = 20, x = 0, y = 0, z = 4000, focal = 460, width = 780, height = 580, distortion = 0 } = {}) =>
  all(uint(1, camera), float(2, focal), float(3, width / 2), float(4, height / 2), float(5, distortion),
    float(6, 1), float(7, 0), float(8, 0), float(9, 0), float(10, -x), float(11, y), float(12, z),
    float(13, x), float(14, y), float(15, z), uint(16, width), uint(17, height));
export const geometry = ({ length = 9000, fieldWidth = 6000, cameras = [] } = {}) =>
  bytes(2, all(bytes(1, all(uint(1, length), uint(2, fieldWidth), uint(3, 1000), uint(4, 180), uint(5, 300))),
    cameras.map((one) => bytes(2, calibration(one)))));

// ---- tracker

const vector = (number, value) => bytes(number, all(value.map((one, i) => float(i + 1, one))));
export const tracked = ({ uuid = 'stranger', source = 'stranger', frame = 1, time = Date.now() / 1000, balls = [], robots = [], kicked } = {}) => all(
  text(1, uuid), text(2, source),
  bytes(3, all(uint(1, frame), double(2, time),
    balls.map((position) => bytes(3, all(vector(1, position), vector(2, [0, 0, 0]), float(3, 1)))),
    robots.map(({ id, team, position }) => bytes(4, all(bytes(1, all(uint(1, id), uint(2, team))), vector(2, position), float(3, 0), float(6, 1)))),
    kicked && bytes(5, all(vector(1, kicked.position), vector(2, kicked.velocity), double(3, kicked.start), double(4, kicked.stop), vector(5, [1, 1]))))));

// ---- GigE Vision's streaming protocol

export const LEADER = 1, TRAILER = 2, PAYLOAD = 3, ALL_IN = 4, MULTIPART = 7;
export const MONO_8 = 0x01080001;
export const IMAGE = 1, EXTENDED_CHUNK = 5, PARTS = 10, WITH_CHUNKS = 0x4000;

const numbers = (...list) => {
  const out = Buffer.alloc(list.reduce((sum, [size]) => sum + size, 0));
  let at = 0;
  for (const [size, value] of list) {
    const number = BigInt.asUintN(8 * size, BigInt(Math.trunc(value)));
    for (let i = 0; i < size; ++i) out[at + i] = Number((number >> BigInt(8 * (size - 1 - i))) & 255n);
    at += size;
  }
  return out;
};
export const gvsp = (kind, frame, id, data = Buffer.alloc(0)) => all(numbers([2, 0], [2, frame], [1, kind], [3, id]), data);
export const extendedGvsp = (kind, frame, id, data = Buffer.alloc(0), parts = 0) =>
  all(numbers([4, 0], [1, 0x80 | kind], [3, parts], [8, frame], [4, id]), data);
export const imageLeader = ({ type = IMAGE, format = MONO_8, width = 640, height = 480, padding = 0 } = {}) =>
  numbers([2, 0], [2, type], [8, 0], [4, format], [4, width], [4, height], [8, 0], [2, padding], [2, 0]);
export const partsLeader = (parts, type = PARTS) => all(numbers([2, 0], [2, type], [8, 0]),
  parts.map(({ width, height, size, format = MONO_8 }) => numbers([2, 1], [6, size], [4, format], [12, 0], [4, width], [4, height], [8, 0], [8, 0])));
export const piece = (offset, data) => all(numbers([2, 0], [6, offset]), data);
/** Asks a camera for the port that it sends images to, as anyone may; the answer ends with the port. */
export const readStreamPort = numbers([4, 0x42010080], [2, 4], [2, 1], [4, 0xd00]);
