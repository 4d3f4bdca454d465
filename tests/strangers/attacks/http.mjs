// SPDX-License-Identifier: Apache-2.0
import { once } from 'node:events';
import { readFileSync } from 'node:fs';
import { connect } from 'node:net';
import { createService } from '../../e2e/service.mjs';

const BODY_BYTES = 1 << 20, MOST_GROWTH_MB = 64;

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

// A body without its last byte. The service only receives it from clients that may make changes.
const HALF_BODY = Buffer.from(`PATCH /api/settings HTTP/1.1\r\nHost: localhost\r\nContent-Length: ${BODY_BYTES}\r\n\r\n[${' '.repeat(BODY_BYTES - 2)}`);

async function attack(host, port, requests, { random, isOver, pause }) {
  const open = [];
  while (!isOver()) {
    const socket = connect({ port, host, localAddress: host });
    socket.on('error', () => {});
    await Promise.race([once(socket, 'connect'), once(socket, 'close')]).catch(() => {});
    const request = random.pick(requests)(random);
    socket.write(request === HALF_BODY || random.below(3) ? request : random.mutated(Buffer.from(request)));
    if (random.below(2)) setTimeout(() => socket.write(random.bytes(random.below(500))), 50);
    open.push(socket);
    if (open.length > 600) open.shift().destroy();
    await pause(5);
  }
  for (const socket of open) socket.destroy();
}

const memoryMb = (pid) => Number(/^VmRSS:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

/** Without passwords everyone on this computer may make changes, so bodies of 1 MiB are received. */
async function attackWithoutPasswords({ random, isOver, pause, check }) {
  const service = await createService('239.255.77.137');
  service.settings.cameras = [];
  try {
    await service.start();
    const first_mb = memoryMb(service.pid());
    let most_mb = first_mb;
    const watch = async () => {
      for (; !isOver(); await pause(200)) most_mb = Math.max(most_mb, memoryMb(service.pid()));
    };
    const requests = [...REQUESTS, ...Array(3).fill(() => HALF_BODY)];
    await Promise.all([watch(), attack('127.0.0.1', service.settings.panel.port, requests, { random, isOver, pause })]);
    check(most_mb - first_mb <= MOST_GROWTH_MB, `without passwords, memory grew by ${(most_mb - first_mb).toFixed(0)} MB`);
    const answer = await fetch(service.address('healthz'));
    check(answer.status === 200, `without passwords, /healthz answers ${answer.status}`);
  } finally {
    await service.end();
  }
}

export default {
  name: 'half requests and nonsense',
  about: 'connections that never send a whole request, invalid requests and WebSocket frames; also to a service without passwords',
  async run(context) {
    const { panel } = context;
    await Promise.all([attack(panel.outside, panel.port, [...REQUESTS, () => HALF_BODY], context), attackWithoutPasswords(context)]);
  },
};
