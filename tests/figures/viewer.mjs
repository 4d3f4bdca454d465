// SPDX-License-Identifier: Apache-2.0
// A viewer of the panel's images without a browser: the necessary part of RFC 6455.
import { once } from 'node:events';
import { connect } from 'node:net';

/** Sends one masked text frame. */
function sendText(socket, message) {
  const body = Buffer.from(JSON.stringify(message));
  const head = body.length < 126 ? Buffer.from([0x81, 0x80 | body.length]) : Buffer.from([0x81, 0x80 | 126, body.length >> 8, body.length & 255]);
  socket.write(Buffer.concat([head, Buffer.alloc(4), body])); // a mask of zeros
}

/** Splits the received bytes into complete frames: {opcode, payload}. */
function frames(onFrame) {
  let rest = Buffer.alloc(0);
  return (bytes) => {
    rest = rest.length ? Buffer.concat([rest, bytes]) : bytes;
    for (;;) {
      if (rest.length < 2) return;
      const short = rest[1] & 127;
      const head = short === 126 ? 4 : short === 127 ? 10 : 2;
      if (rest.length < head) return;
      const length = short === 126 ? rest.readUInt16BE(2) : short === 127 ? Number(rest.readBigUInt64BE(2)) : short;
      if (rest.length < head + length) return;
      onFrame(rest[0] & 15, rest.subarray(head, head + length));
      rest = rest.subarray(head + length);
    }
  };
}

/** Views one camera until end() is called; acknowledges each image on arrival, like the panel. */
export async function openViewer(port, preview) {
  const socket = connect(port, '127.0.0.1');
  await once(socket, 'connect');
  socket.setNoDelay();
  socket.write(`GET /api/ws HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n`
    + 'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n');
  const viewer = { pictures: 0, bytes: 0, end: () => socket.destroy() };
  let greeting = '';
  const read = frames((opcode, payload) => {
    if (opcode !== 2) return;
    viewer.pictures++;
    viewer.bytes += payload.length;
    const { camera, frame } = JSON.parse(payload.subarray(4, 4 + payload.readUInt32LE(0)));
    sendText(socket, { ack: { camera, frame } });
  });
  await new Promise((resolve, reject) => {
    socket.once('error', reject);
    socket.on('data', (bytes) => {
      if (greeting === null) return read(bytes);
      greeting += bytes.toString('latin1');
      const end = greeting.indexOf('\r\n\r\n');
      if (end < 0) return;
      if (!greeting.startsWith('HTTP/1.1 101')) return reject(new Error(greeting.split('\r\n')[0]));
      const rest = Buffer.from(greeting.slice(end + 4), 'latin1');
      greeting = null;
      read(rest);
      resolve();
    });
  });
  sendText(socket, { subscribe: ['status', 'detections'] });
  sendText(socket, { preview });
  return viewer;
}
