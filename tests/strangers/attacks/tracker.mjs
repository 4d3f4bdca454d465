// SPDX-License-Identifier: Apache-2.0
import { tracked } from '../wire.mjs';

export default {
  name: 'tracker packets',
  about: 'kicks with non-finite times, tracks of other sources, random datagrams at full speed, empty datagrams',
  async run({ socketAt, random, tracker, isOver, pause }) {
    const sockets = await Promise.all(['127.0.0.91', '127.0.0.92'].map((address) => socketAt(address)));
    let frame = 0;
    while (!isOver()) {
      const { send } = random.pick(sockets);
      const n = () => random.number();
      for (let i = 0; i < 40; ++i) {
        const packet = tracked({
          uuid: random.pick(['stranger', 'other', `source ${random.below(1000)}`, 'x'.repeat(2000)]), frame: ++frame, time: random.pick([Date.now() / 1000, n()]),
          balls: [[n(), n(), n()]], robots: [{ id: random.below(40), team: random.below(4), position: [n(), n()] }],
          kicked: { position: [n(), n()], velocity: [n(), n(), n()], start: n(), stop: n() },
        });
        send(random.below(3) ? packet : random.mutated(packet), tracker.port, tracker.group);
      }
      // More data than a real field produces.
      for (let i = 0; i < 20; ++i) send(random.bytes(16).toString('hex').repeat(1500), tracker.port, tracker.group);
      for (let i = 0; i < 20; ++i) send(Buffer.alloc(0), tracker.port, tracker.group);
      await pause(20);
    }
  },
};
