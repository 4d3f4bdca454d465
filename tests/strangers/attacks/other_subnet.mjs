// SPDX-License-Identifier: Apache-2.0
import { gameController } from '../../e2e/league_messages.mjs';
import { listenTo } from '../../e2e/service.mjs';
import { detection, geometry, tracked } from '../wire.mjs';

export default {
  name: 'another subnet',
  about: 'sightings, tracks and a game controller on the field\'s network card, from an address outside its subnet',
  async run({ socketAt, random, vision, tracker, referee, panel, isOver, pause, check }) {
    const { send } = await socketAt(panel.outside);
    let arrived = 0;
    const hearing = await listenTo(vision.group, vision.port, (_, { address }) => { if (address === panel.outside) arrived++; });
    for (let frame = 1; !isOver(); ++frame) {
      const x = (random.next() - 0.5) * 9000, y = (random.next() - 0.5) * 6000, id = random.below(12);
      const packet = detection({ frame, camera: random.pick([0, 1, 50]), yellow: [{ id, x, y }], blue: [{ id, x: y, y: x }], balls: [{ x, y }] });
      send(random.below(3) ? packet : random.mutated(packet), vision.port, vision.group);
      if (frame % 20 === 0) send(geometry({ cameras: [{ camera: 50, z: 4000 }] }), vision.port, vision.group);
      send(tracked({ frame, balls: [[x / 1000, y / 1000, 0]], robots: [{ id, team: 1, position: [x / 1000, y / 1000] }] }), tracker.port, tracker.group);
      send(gameController({ yellow: ['ibis'], blue: ['Dire Wolves'], source: 'elsewhere', stage: random.below(20), command: random.below(30) }), referee.port, referee.group);
      await pause(10);
    }
    hearing.close();
    check(arrived > 0, 'no packet from another subnet arrived');
  },
};
