// SPDX-License-Identifier: Apache-2.0
// Input from careless or hostile network clients: each gets a clear refusal or a closed connection, while all other
// clients are served.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { readFileSync } from 'node:fs';
import { connect } from 'node:net';
import { after, before, describe, it } from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { answerPings, becomes as looksUntil, createService } from './service.mjs';

const service = await createService('239.255.77.81');

/** A connection that collects the data received so far. */
async function open() {
  const socket = connect(service.settings.panel.port, '127.0.0.1');
  socket.received = '';
  socket.on('data', (bytes) => { socket.received += bytes.toString('latin1'); });
  socket.on('error', () => {});  // the service may reset it
  await once(socket, 'connect');
  return socket;
}

/** The service's answer, until it closes the connection or `wanted` appears in the answer. */
async function answerTo(request, wanted) {
  const socket = await open();
  socket.write(request);
  await becomes(() => socket.closed || (wanted && socket.received.includes(wanted)), 'the connection is not answered');
  socket.destroy();
  return socket.received;
}

const becomes = (condition, complaint) => looksUntil(condition, Boolean, () => complaint);

/** Whether the service has an open connection from our port, according to the kernel. */
function isOpenInService(port) {
  const ESTABLISHED = '01';
  const address = (number) => `0100007F:${number.toString(16).toUpperCase().padStart(4, '0')}`;
  const wanted = `${address(service.settings.panel.port)} ${address(port)} ${ESTABLISHED} `;
  return readFileSync('/proc/net/tcp', 'latin1').includes(wanted);
}

/** Checks that the service still answers. */
async function isWell() {
  const answer = await fetch(service.address('api/status'));
  assert.equal(answer.status, 200);
  await answer.json();
}

const frame = (opcode, payload) => {
  const bytes = Buffer.from(payload);
  const head = bytes.length < 126 ? [0x80 | bytes.length] : [0x80 | 126, bytes.length >> 8, bytes.length & 0xff];
  return Buffer.concat([Buffer.from([0x80 | opcode, ...head, 0, 0, 0, 0]), bytes]);  // masked with zeros
};
const TEXT = 1, BINARY = 2;

async function viewer() {
  const socket = await open();
  socket.write('GET /api/ws HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n' +
    'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n');
  await becomes(() => socket.received.includes('\r\n\r\n'), 'no WebSocket');
  assert.match(socket.received, /^HTTP\/1\.1 101 /);
  answerPings(socket);
  return socket;
}

describe('bad input from the network', () => {
  before(async () => {
    await service.start();
    await service.statusBecomes((status) => status.cameras.every(({ frames }) => frames > 0));
  });
  after(() => service.end());

  it('is refused if a request is invalid', async () => {
    const patch = (headers, body = '') => `PATCH /api/settings HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n${headers}\r\n${body}`;
    const sized = (body) => patch(`Content-Length: ${body.length}\r\n`, body);
    for (const [request, status] of [
      [sized(' '.repeat(1024 * 1024 + 1)), 413],
      [patch('Content-Length: 2000000000\r\n'), 413],
      [patch('Content-Length: -1\r\n'), 400],
      [patch('Transfer-Encoding: chunked\r\n', '0\r\n\r\n'), 411],
      [patch(`X: ${'x'.repeat(20_000)}\r\n`), 431],
      [`GET /${'x'.repeat(2000)} HTTP/1.1\r\n\r\n`, 414],
      ['\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03', 400],  // TLS
      ['FETCH / HTTP/1.1\r\n\r\n', 400],
      [sized('['.repeat(300_000)), 400],
      [sized('[{"op": "replace", "path": "/site", "value": "\xff"}]'), 400],
      [sized('{"op": "replace"}'), 422],
    ]) {
      const answer = await answerTo(Buffer.from(request, 'latin1'));
      assert.match(answer, new RegExp(`^HTTP/1\\.1 ${status} (?=[^]*\r\nX-Content-Type-Options: nosniff\r\n)[^]*\r\n\r\n{"error":"[^]+"}$`), request.slice(0, 100));
    }
    await isWell();
  });

  it('cannot read files outside the panel', async () => {
    for (const target of ['/../../../../../../etc/passwd', '/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd', '/..%2f..%2f..%2f..%2fetc%2fpasswd',
      '//etc/passwd', '/assets/../../package.json', '/assets/%2e%2e/%2e%2e/package.json', '/index.html%00.png', '/..%5c..%5cpackage.json', 'file:///etc/passwd']) {
      const answer = await answerTo(`GET ${target} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n`);
      assert.match(answer, /^HTTP\/1\.1 40[04] /, target);
      assert.doesNotMatch(answer, /root:|ssl-visiond-webui/, target);
    }
  });

  it('is answered over a WebSocket, or ends it', async () => {
    const other = await viewer();
    const small = await viewer();
    small.pause();  // a client that only sends
    for (let i = 0; i < 20_000; ++i) small.write(frame(TEXT, '{"nonsense": 1}'));
    const large = await viewer();
    for (let i = 0; i < 500; ++i) large.write(frame(TEXT, '['.repeat(16_000)));
    await isWell();
    await becomes(() => large.received.includes('nested deeper'), 'no answer to what is too deep');

    const binary = await viewer();
    binary.write(frame(BINARY, Buffer.from([0, 255, 128, 1])));
    await becomes(() => binary.received.includes('not JSON'), 'no answer to what is no text');
    const oversized = await viewer();
    oversized.write(frame(TEXT, ' '.repeat(20_000)));
    await becomes(() => oversized.closed, 'too large a message does not end its connection');
    const lying = await viewer();  // a frame with a length of 2^63 bytes
    lying.write(Buffer.from([0x81, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]));
    await becomes(() => lying.closed, 'too large a frame does not end its connection');
    const unmasked = await viewer();
    unmasked.write(Buffer.from([0x81, 2, 0x7b, 0x7d]));
    await becomes(() => unmasked.closed, 'a frame without a mask does not end its connection');

    other.write(frame(TEXT, '{"subscribe": ["status"]}'));
    await becomes(() => other.received.includes('"topic":"status"'), 'another viewer is not served');
    for (const socket of [other, small, large, binary]) socket.destroy();
  });

  it('delays nobody: half-open and idle connections, slow readers', async () => {
    const slow = await open();
    slow.write('GET /api/cameras/0/stream.mjpg?width=16384&quality=100 HTTP/1.1\r\nHost: localhost\r\n\r\n');
    await becomes(() => slow.received.includes('\xff\xd8'), 'no stream');
    slow.pause();
    const slowPort = slow.localPort;

    const idle = [];
    for (let i = 0; i < 200; ++i) {
      idle.push(await open());
      if (i % 4 === 1) idle[i].write('GET /api/sta');
      if (i % 4 === 2) idle[i].write('PATCH /api/settings HTTP/1.1\r\nContent-Length: 10\r\n\r\n[');
      if (i % 4 === 3) idle[i].write('GET /api/status HTTP/1.1\r\nHost: localhost\r\n\r\n');
    }
    const times = [];
    for (let i = 0; i < 200; ++i) {
      const begin = performance.now();
      await isWell();
      times.push(performance.now() - begin);
    }
    times.sort((a, b) => a - b);
    const quantile = (share) => times[Math.floor(share * (times.length - 1))].toFixed(1);
    console.log(`status beside 200 idle connections and a slow reader: median ${quantile(0.5)} ms, 99 % ${quantile(0.99)} ms`);
    for (const socket of idle) socket.destroy();

    // The system's buffers on both sides fill first. The service closes the connection after 30 s without progress.
    await becomes(() => !isOpenInService(slowPort), 'the stream of a client that takes nothing does not end');
    slow.destroy();
  });

  it('does not prevent the service from stopping', async () => {
    for (let round = 0; round < 5; ++round) {
      // Some requests arrive before the shutdown, some during it: none may access freed objects.
      const underWay = Array.from({ length: 24 }, async (_, i) => {
        const [path, options] = [
          ['api/status', {}], ['api/cameras/0/stream.mjpg', {}], ['api/cameras/0/snapshot.jpg', {}],
          ['api/settings', { method: 'PATCH', body: JSON.stringify([{ op: 'replace', path: '/panel/names', value: [`name${round}-${i}.local`] }]) }],
        ][i % 4];
        await pause(i * (round + 1));
        const answer = await fetch(service.address(path), options);
        await answer.arrayBuffer();
      });
      for (let i = 0; i < 4; ++i) (await viewer()).write(frame(TEXT, '{"subscribe": ["status", "detections"]}'));
      await Promise.race(underWay);
      await service.stop();
      await Promise.allSettled(underWay);
      await service.start();
    }
  });
});
