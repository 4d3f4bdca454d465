// SPDX-License-Identifier: Apache-2.0
// The pipeline's latency as seen by teams: t_sent - t_capture of the packets received.
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { setTimeout as pause } from 'node:timers/promises';
import { detectionOf } from '../e2e/protobuf.mjs';

/** The demo's camera at 1280 x 1024 and 60 Hz. */
export function largerCamera(camera) {
  const { principal_point_x: x, principal_point_y: y, focal_length: f } = camera.calibration;
  const scale = 1280 / 780;
  return {
    ...camera,
    source: { ...camera.source, width: 1280, height: 1024, frame_rate_hz: 60 },
    calibration: {
      ...camera.calibration, principal_point_x: x * scale, principal_point_y: y * scale, focal_length: f * scale,
      pixel_image_width: 1280, pixel_image_height: 1024,
    },
  };
}

export const percentile = (values, share) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * share))];
/** Number of missing packets in a block of one camera. */
export const missing = (block) => block.slice(1).reduce((sum, frame, i) => sum + Math.max(0, frame.number - block[i].number - 1), 0);

/** Receives a service's packets; `block` collects them for so many seconds: {camera, number, latencyMs}. */
export async function receivePackets(service) {
  let frames = [];
  const { group, port } = service.settings.network.vision;
  const receiver = createSocket({ type: 'udp4', reuseAddr: true });
  receiver.on('message', (packet) => {
    const frame = detectionOf(packet);
    if (frame) frames.push({ camera: frame.camera_id, number: frame.frame_number, latencyMs: (frame.t_sent - frame.t_capture) * 1e3 });
  });
  receiver.bind(port, () => receiver.addMembership(group, '127.0.0.1'));
  await once(receiver, 'listening');
  return {
    async block(seconds) {
      frames = [];
      await pause(seconds * 1e3);
      return frames;
    },
    close: () => receiver.close(),
  };
}
