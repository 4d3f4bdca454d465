// SPDX-License-Identifier: Apache-2.0
import { once } from 'node:events';
import {
  ALL_IN, EXTENDED_CHUNK, IMAGE, LEADER, MULTIPART, PARTS, PAYLOAD, TRAILER, WITH_CHUNKS, extendedGvsp, gvsp, imageLeader, partsLeader, piece, readStreamPort,
} from '../wire.mjs';

const CONTROL_PORT = 3956, ANSWER_MS = 10_000;

/** Far from the camera's own frame numbers: just below a forged one, they would count as late. */
let frame = 0x4000;
const leaderOf = (parts, type) => extendedGvsp(LEADER, ++frame, 0, partsLeader(parts, type), parts.length);
const trailer = (id) => extendedGvsp(TRAILER, frame, id);

const KNOWN = [
  () => [leaderOf([{ width: 700, height: 700, size: 490_000 }]), trailer(1)],
  () => [leaderOf([{ width: 16384, height: 16384, size: 2 ** 28 }]), trailer(1)],
  () => [leaderOf([{ width: 1, height: 1, size: 2 ** 40 }]), trailer(1)],
  () => [leaderOf([{ width: 640, height: 480, size: 307_200 }], PARTS | WITH_CHUNKS), trailer(1)],
  () => [extendedGvsp(LEADER, ++frame, 0, imageLeader({ type: IMAGE | WITH_CHUNKS })), trailer(1)],
  () => [extendedGvsp(LEADER, ++frame, 0, imageLeader({ type: EXTENDED_CHUNK, padding: 65535 })), trailer(2)],
  () => [extendedGvsp(TRAILER, ++frame, 0xfffffffe)],
  () => [extendedGvsp(TRAILER, ++frame, 0xffffff), extendedGvsp(PAYLOAD, frame, 0xfffff0, Buffer.alloc(1000))],
  () => [extendedGvsp(ALL_IN, ++frame, 0, imageLeader()), extendedGvsp(PAYLOAD, frame, 1_000_000, Buffer.alloc(1000))],
  () => [extendedGvsp(LEADER, ++frame, 0, imageLeader()), extendedGvsp(MULTIPART, frame, 1, piece(2 ** 47, Buffer.alloc(100)))],
  () => [gvsp(LEADER, ++frame, 0, imageLeader()), gvsp(TRAILER, frame, 1)],
  () => [Buffer.alloc(0), Buffer.alloc(1), Buffer.alloc(7)],
];

export default {
  name: 'GigE packets',
  about: 'forged leaders, trailers and blocks for a camera\'s stream, from this computer and from others',
  async run({ socketAt, random, gige, isOver, pause }) {
    const sockets = [await socketAt('127.0.0.1'), await socketAt('127.0.0.66')];
    const [asker] = sockets;
    const answered = once(asker.socket, 'message', { signal: AbortSignal.timeout(ANSWER_MS) });
    asker.send(readStreamPort, CONTROL_PORT, gige.address);
    const [answer] = await answered.catch(() => { throw new Error('the camera does not say where it sends its images to'); });
    const port = answer.readUInt16BE(10);
    while (!isOver()) {
      const packets = random.pick(KNOWN)();
      for (const packet of packets) {
        random.pick(sockets).send(random.below(3) ? packet : random.mutated(packet), port, gige.address);
      }
      await pause(2);
    }
  },
};
