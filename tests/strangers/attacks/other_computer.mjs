// SPDX-License-Identifier: Apache-2.0
import { detection, geometry } from '../wire.mjs';

const ASIDE_MM = 100, HELD_UP_MS = 300;

export default {
  name: 'another computer, 100 mm off',
  about: 'repeats our robots and ball as sightings of its own cameras, 100 mm aside and alternately delayed by 300 ms',
  async run({ socketAt, vision, ownFrames, isOver, pause }) {
    const { send } = await socketAt('127.0.0.81');
    let frame = 0;
    const stop = ownFrames(({ robots_yellow: yellow = [], robots_blue: blue = [], balls = [], t_capture: capture, camera_id: camera }) => {
      const aside = ({ robot_id: id, x, y, orientation, height, z }) => ({ id, x: x + ASIDE_MM, y, orientation, height, z });
      const packet = detection({ frame: ++frame, capture, camera: 40 + camera, yellow: yellow.map(aside), blue: blue.map(aside), balls: balls.map(aside) });
      const isHeldUp = Math.floor(Date.now() / 5000) % 2 === 1;
      setTimeout(() => { if (!isOver()) send(packet, vision.port, vision.group); }, isHeldUp ? HELD_UP_MS : 0);
    });
    while (!isOver()) {
      send(geometry({ cameras: [{ camera: 40, z: 4000 }, { camera: 41, z: 4000, x: 1000 }] }), vision.port, vision.group);
      await pause(200);
    }
    stop();
  },
};
