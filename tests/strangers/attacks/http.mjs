// SPDX-License-Identifier: Apache-2.0
import { once } from 'node:events';
import { connect } from 'node:net';

const REQUESTS = [
  (random) => random.bytes(random.below(2000)),
  () => 'GET /api/status HTTP/1.1\r\n',
  () => `GET /${'x'.repeat(3000)} HTTP/1.1\r\n\r\n`,
  () => 'POST /api/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n[[[[',
  () => 'PATCH /api/settings HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nffffffff\r\n',
  () => `POST /api/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 16000\r\n\r\n${'['.repeat(16000)}`,
  () => `POST /api/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 15000\r\n\r\n[${'[],'.repeat(4999)}]`,
  () => 'GET /../../../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n',
  () => 'GET /api/recordings/logs/..%2f..%2fpasswords.json HTTP/1.1\r\nHost: localhost\r\n\r\n',
  () => 'DELETE /api/recordings/logs/x HTTP/1.1\r\nHost: localhost\r\n\r\n',
  () => 'GET /api/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n',
];

export default {
  name: 'half requests and nonsense',
  about: 'connections that never send a whole request, requests that are none, WebSocket frames that are none',
  async run({ panel, random, isOver, pause }) {
    const open = [];
    while (!isOver()) {
      const socket = connect({ port: panel.port, host: panel.outside, localAddress: panel.outside });
      socket.on('error', () => {});
      await Promise.race([once(socket, 'connect'), once(socket, 'close')]).catch(() => {});
      const request = Buffer.from(random.pick(REQUESTS)(random));
      socket.write(random.below(3) ? request : random.mutated(request));
      if (random.below(2)) setTimeout(() => socket.write(random.bytes(random.below(500))), 50);
      open.push(socket);
      if (open.length > 600) open.shift().destroy();
      await pause(5);
    }
    for (const socket of open) socket.destroy();
  },
};
