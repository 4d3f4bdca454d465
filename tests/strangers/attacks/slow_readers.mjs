// SPDX-License-Identifier: Apache-2.0
import { connect } from 'node:net';

const upgrade = 'GET /api/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n';
/** A text frame, masked with zeros. */
const message = (json) => {
  const text = Buffer.from(JSON.stringify(json));
  return Buffer.concat([Buffer.from([0x81, 0x80 | 126, text.length >> 8, text.length & 255, 0, 0, 0, 0]), text]);
};
const get = (path, cookie) => `GET /${path} HTTP/1.1\r\nHost: localhost\r\nCookie: ${cookie}\r\n\r\n`;

export default {
  name: 'readers that take nothing',
  about: 'clients with the viewers\' password that ask for large images, streams, previews and settings, and never read',
  async run({ panel, random, signIn, isOver, pause }) {
    const cookie = await signIn('viewer');
    const open = [];
    const ways = [
      (socket) => socket.write(get('api/cameras/0/snapshot.jpg?quality=100', cookie)),
      (socket) => socket.write(get('api/cameras/1/stream.mjpg?quality=100&width=16384', cookie)),
      (socket) => { for (let i = 0; i < 30; ++i) socket.write(get('api/schema', cookie)); },
      (socket) => { for (let i = 0; i < 30; ++i) socket.write(get('api/status', cookie)); },
      (socket) => {
        socket.write(upgrade.replace('\r\n\r\n', `\r\nCookie: ${cookie}\r\n\r\n`));
        setTimeout(() => {
          socket.write(message({ subscribe: ['status', 'detections'] }));
          for (const camera of [0, 1, 2]) socket.write(message({ preview: { camera, width: 16384, quality: 100, fps: 30 } }));
        }, 100);
      },
    ];
    while (!isOver()) {
      const socket = connect({ port: panel.port, host: panel.outside, localAddress: panel.outside });
      socket.on('error', () => {});
      socket.pause();
      socket.once('connect', () => random.pick(ways)(socket));
      open.push(socket);
      if (open.length > 400) open.splice(0, 100).forEach((one) => one.destroy());
      await pause(20);
    }
    for (const socket of open) socket.destroy();
  },
};
