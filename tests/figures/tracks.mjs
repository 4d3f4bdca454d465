// SPDX-License-Identifier: Apache-2.0
// The whole chain from pixels to tracks: four simulated cameras with poses that differ from their calibrations,
// different capture times, clock offsets and jitter, and lost images. Prints the tracks' errors, the cameras'
// disagreement, and the latency that the field's stack adds to the cameras' packets.
//   node tracks.mjs [--seconds 60] [--seed 1] [--rate 75] [--robots 11] [--stretches 8]
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import { setTimeout as pause } from 'node:timers/promises';
import { parseArgs } from 'node:util';
import { createService, freeUdpPort, root } from '../e2e/service.mjs';

const { values: options } = parseArgs({
  options: {
    seconds: { type: 'string', default: '60' }, seed: { type: 'string', default: '1' }, rate: { type: 'string', default: '75' },
    robots: { type: 'string', default: '11' }, stretches: { type: 'string', default: '8' },
  },
});
const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const LAB = process.env.SSLV_LAB ?? join(root, 'build/release/bin/ssl-visionlab');
const GROUP = '239.255.77.79';

/** Per camera, in mm, degrees, fraction of the frame interval, ms. */
const ERRORS = [
  { moved_x_mm: 1.4, moved_y_mm: -0.6, turned_deg: 0.02, phase: 0, time_offset_ms: 0.3, time_jitter_ms: 0.2, drop_share: 0.02 },
  { moved_x_mm: -0.9, moved_y_mm: 1.1, turned_deg: -0.01, phase: 0.3, time_offset_ms: -0.4, time_jitter_ms: 0.2, drop_share: 0.02 },
  { moved_x_mm: -0.7, moved_y_mm: -1.2, turned_deg: 0.015, phase: 0.55, time_offset_ms: 0.1, time_jitter_ms: 0.2, drop_share: 0.02 },
  { moved_x_mm: 1, moved_y_mm: 0.8, turned_deg: -0.02, phase: 0.8, time_offset_ms: -0.1, time_jitter_ms: 0.2, drop_share: 0.02 },
];

/** A camera looking down on a quarter of a 9 x 6 m field, with a margin of half a metre on each side. */
function cameraOf(model, id) {
  const [x, y, z] = [id >> 1 ? 2250 : -2250, id & 1 ? 1500 : -1500, 4000];
  return {
    ...model, id, name: '',
    source: {
      ...model.source, frame_rate_hz: Number(options.rate), seed: Number(options.seed),
      robots_yellow: Number(options.robots), robots_blue: Number(options.robots), errors: ERRORS[id],
    },
    calibration: {
      focal_length: 560, principal_point_x: 389.5, principal_point_y: 289.5, distortion: 0.05, q0: 1, q1: 0, q2: 0, q3: 0,
      tx: -x, ty: y, tz: z, pixel_image_width: 780, pixel_image_height: 580,
    },
  };
}

const service = await createService(GROUP);
const { settings } = service;
settings.cameras = ERRORS.map((_, id) => cameraOf(settings.cameras[0], id));
settings.network.tracker = { enabled: true, group: GROUP, port: await freeUdpPort() };
const [ctl, lab] = [CTL, LAB].map((program) => (...words) => execFileSync(program, ['--daemon', service.address('').replace(/\/$/, ''), ...words], { encoding: 'utf8' }));

try {
  await service.start();
  await service.statusBecomes(({ cameras }) => cameras.length === 4 && cameras.every(({ state }) => state === 'running'));
  await pause(20_000); // until the cameras' clocks are aligned
  console.log(`Four simulated cameras of 780 x 580, ${options.rate} Hz, ${2 * Number(options.robots)} robots, seed ${options.seed}, ${options.seconds} s:\n`);
  console.log(lab('score', '--tracks', options.seconds));
  console.log(ctl('field', 'agreement'));
  console.log(ctl('field').split('\n').slice(-12).join('\n'));

  // The same cameras with and without the field's stack, alternating.
  const [STACK, NONE] = [['gather', 'clocks', 'agreement', 'track', 'publish'], []];
  const p99 = { with: [], without: [] };
  for (let i = 0; i < Number(options.stretches); ++i) {
    const way = i % 2 ? 'without' : 'with';
    ctl('settings', 'set', '/field/stack', JSON.stringify(i % 2 ? NONE : STACK));
    await pause(12_000); // then the last 512 images are all from this stretch
    for (const camera of JSON.parse(ctl('cameras', '--json'))) p99[way].push(camera.latency_ms.p99 * 1000);
  }
  const middle = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];
  console.log(`\np99 from an image to its packet, median over cameras and stretches of 12 s: ${middle(p99.with).toFixed(0)} us with the field's stack, ${middle(p99.without).toFixed(0)} us without`);
} finally {
  await service.end();
}
