// SPDX-License-Identifier: Apache-2.0
// Messages of other computers on a field's network, encoded by hand, independent of the service's protobuf code.
const varint = (value) => (value < 128 ? [value] : [(value & 127) | 128, ...varint(value >> 7)]);
const bytesField = (number, bytes) => [number * 8 + 2, ...varint(bytes.length), ...bytes];
const double = (number, value) => { const bytes = Buffer.alloc(8); bytes.writeDoubleLE(value); return [number * 8 + 1, ...bytes]; };
const team = (text, allowed, score = 0) => [...bytesField(1, [...Buffer.from(text)]), 0x10, score, ...(allowed === undefined ? [] : [13 * 8, allowed])];
/** A message of the game controller; by default in the break before the first half. */
export const gameController = ({ yellow = ['', undefined], blue = ['', undefined], source: from = 'field', stage = 0, command = 0, matchType = 0 } = {}) =>
  Buffer.from([0x10, stage, 0x20, command, ...bytesField(7, team(...yellow)), ...bytesField(8, team(...blue)), ...varint(18 * 8 + 2), from.length, ...Buffer.from(from), ...varint(19 * 8), matchType]);
/** Another vision's detection from a camera, and its field geometry. */
export const detectionOf = (camera) => Buffer.from(bytesField(1, [0x08, 1, ...double(2, 1), ...double(3, 1), 0x20, camera]));
export const geometryOf = (length, width) => Buffer.from(bytesField(2, bytesField(1, [0x08, ...varint(length), 0x10, ...varint(width), 0x18, ...varint(1000), 0x20, ...varint(180), 0x28, ...varint(300)])));
