// SPDX-License-Identifier: Apache-2.0
import { detection, geometry } from '../wire.mjs';

const robots = (random, more = {}) => Array.from({ length: random.below(12) }, () => ({ id: random.below(16), x: (random.next() - 0.5) * 9000, y: (random.next() - 0.5) * 6000, ...more }));

/** Camera 21 is at a height of 500 mm; both cameras report a robot of that height, so its plane contains camera 21. */
function* dividesByNothing(random) {
  yield geometry({ cameras: [{ camera: 20, z: 4000 }, { camera: 21, z: 500, x: 100 }] });
  const id = random.below(6);
  yield detection({ camera: 20, yellow: [{ id, height: 500 }] });
  yield detection({ camera: 21, yellow: [{ id, height: 500 }] });
  yield detection({ camera: 20, yellow: [{ id, height: 499.9999 }] });
}
function* manyCameras() {
  yield geometry({ cameras: Array.from({ length: 64 }, (_, i) => ({ camera: 100 + i })) });
  yield geometry({ cameras: Array.from({ length: 400 }, (_, i) => ({ camera: i * 10_000_019 })) });
  for (let camera = 2; camera < 300; ++camera) yield detection({ camera });
}
function* senseless(random) {
  const n = () => random.number();
  yield detection({ camera: random.below(300), capture: n(), sent: n(), yellow: [{ id: 3, x: n(), y: n(), orientation: n(), height: n(), confidence: n() }], balls: [{ x: n(), y: n(), z: n(), confidence: n() }] });
  yield geometry({ length: n() || 1, fieldWidth: n() || 1, cameras: [{ camera: 20, x: n(), y: n(), z: n(), focal: n(), distortion: n(), width: random.below(70_000), height: random.below(70_000) }] });
  yield detection({ camera: 20, yellow: Array.from({ length: 1000 }, (_, id) => ({ id })), balls: Array.from({ length: 500 }, () => ({})) });
}
/** Detections beside our own, some with the ids of our own cameras. */
function* aside(random) {
  yield geometry({ cameras: [{ camera: 30, z: 4000 }] });
  yield detection({ camera: random.pick([0, 1, 30]), yellow: robots(random), blue: robots(random), balls: [{ x: random.below(3000) }] });
}

export default {
  name: 'vision packets',
  about: 'numbers that cause division by zero, 64 and more cameras, non-finite numbers, duplicate camera ids, mutations',
  async run({ socketAt, random, vision, isOver, pause }) {
    const sockets = await Promise.all(['127.0.0.71', '127.0.0.72', '127.0.0.73'].map((address) => socketAt(address)));
    while (!isOver()) {
      const { send } = random.pick(sockets);
      for (const packet of random.pick([dividesByNothing, manyCameras, senseless, senseless, aside])(random)) {
        send(random.below(3) ? packet : random.mutated(packet), vision.port, vision.group);
        if (random.below(20) === 0) await pause(1);
      }
      await pause(10);
    }
  },
};
