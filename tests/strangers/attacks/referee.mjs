// SPDX-License-Identifier: Apache-2.0
import { gameController } from '../../e2e/league_messages.mjs';

export default {
  name: 'game controllers',
  about: 'other game controllers with other teams, stages and commands, names of any length, mutations, random and empty datagrams',
  async run({ socketAt, random, referee, isOver, pause }) {
    const sockets = await Promise.all(['127.0.0.101', '127.0.0.102'].map((address) => socketAt(address)));
    while (!isOver()) {
      const { send } = random.pick(sockets);
      const name = () => random.pick(['ibis', '', '\u0000\u202e', 'Dire Wolves', 'x'.repeat(100), 'ö'.repeat(50)]);
      const packet = gameController({
        yellow: [name(), random.below(100), random.below(100)], blue: [name(), random.below(100)], source: `stranger ${random.below(50)}`, stage: random.below(20), command: random.below(30), matchType: random.below(9),
      });
      send(random.below(2) ? packet : random.mutated(packet), referee.port, referee.group);
      send(random.bytes(random.below(1400)), referee.port, referee.group);
      send(Buffer.alloc(0), referee.port, referee.group);
      await pause(5);
    }
  },
};
