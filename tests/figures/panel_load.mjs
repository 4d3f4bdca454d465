// SPDX-License-Identifier: Apache-2.0
// The cost of viewers and idle connections: the pipeline's latency with and without them, measured from the packets to
// the teams (t_sent - t_capture), and the API's response time. Prints a Markdown table.
//   node panel_load.mjs [seconds of each block; default 10]
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { connect } from 'node:net';
import { createInterface } from 'node:readline';
import { setTimeout as pause } from 'node:timers/promises';
import { fileURLToPath } from 'node:url';
import { createService } from '../e2e/service.mjs';
import { largerCamera, missing, percentile, receivePackets } from './packets.mjs';

const BLOCK_S = Number(process.argv[2] ?? 10);
const ROUNDS = 6; // each: without and with viewers; interleaved so that drift of the machine affects both
const VIEWERS = 20;
const PREVIEW = { camera: 0, width: 640, quality: 70, fps: 30 };

const service = await createService('239.255.77.90');
service.settings.cameras = [largerCamera(service.settings.cameras[0])];
const packets = await receivePackets(service);
const { block } = packets;

async function watched(seconds) {
  const viewers = spawn(process.execPath, [fileURLToPath(new URL('viewers.mjs', import.meta.url)), service.settings.panel.port, VIEWERS, JSON.stringify(PREVIEW)], { stdio: ['pipe', 'pipe', 'inherit'] });
  const lines = createInterface(viewers.stdout)[Symbol.asyncIterator]();
  await lines.next();
  await pause(1000);
  const seen = await block(seconds);
  viewers.stdin.end();
  const { value } = await lines.next();
  await pause(500); // lets pending transfers finish
  return { seen, ...JSON.parse(value) };
}

// ---- response times

async function answers(count) {
  const times = [];
  for (let i = 0; i < count; i++) {
    const begin = performance.now();
    await (await fetch(service.address('api/status'))).arrayBuffer();
    times.push(performance.now() - begin);
  }
  return times;
}

async function idleConnections(count) {
  const sockets = [];
  for (let i = 0; i < count; i++) {
    const socket = connect(service.settings.panel.port, '127.0.0.1');
    await once(socket, 'connect');
    sockets.push(socket);
  }
  return sockets;
}

/** Requests an image stream and never reads it. */
function slowReader() {
  const socket = connect(service.settings.panel.port, '127.0.0.1');
  socket.pause();
  socket.write('GET /api/cameras/0/stream.mjpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n');
  return socket;
}

// ---- the table

const encoded = async () => (await (await fetch(service.address('api/diagnostics'))).json()).web.jpegs_encoded;

try {
  await service.start();
  await service.statusBecomes(({ cameras }) => cameras[0].frames > 300);

  const without = [], withViewers = [];
  const worst = { without: [], withViewers: [] }; // p99 of each block, to show its natural variation
  let pictures = 0, lost = 0, lostWith = 0, jpegsWithout = 0;
  for (let round = 0; round < ROUNDS; round++) {
    const before = await encoded();
    const alone = await block(BLOCK_S);
    jpegsWithout += await encoded() - before;
    without.push(...alone.map(({ latencyMs }) => latencyMs));
    worst.without.push(percentile(alone.map(({ latencyMs }) => latencyMs), 0.99));
    lost += missing(alone);
    const crowd = await watched(BLOCK_S);
    withViewers.push(...crowd.seen.map(({ latencyMs }) => latencyMs));
    worst.withViewers.push(percentile(crowd.seen.map(({ latencyMs }) => latencyMs), 0.99));
    lostWith += missing(crowd.seen);
    pictures += crowd.pictures;
  }
  const p = (values, share) => percentile(values, share).toFixed(3);
  console.log(`One camera, 1280 x 1024, 60 Hz; ${ROUNDS} times ${BLOCK_S} s each, in turn\n`);
  const range = (values) => `${Math.min(...values).toFixed(2)} to ${Math.max(...values).toFixed(2)}`;
  const change = (share) => `${((percentile(withViewers, share) / percentile(without, share) - 1) * 100).toFixed(1)} %`;
  console.log('| | frames | missing | latency p50, ms | p99, ms | p99 of single blocks | pictures a second and viewer |');
  console.log('|---|---:|---:|---:|---:|---:|---:|');
  console.log(`| no viewer (${jpegsWithout} JPEGs made) | ${without.length} | ${lost} | ${p(without, 0.5)} | ${p(without, 0.99)} | ${range(worst.without)} | |`);
  console.log(`| ${VIEWERS} viewers | ${withViewers.length} | ${lostWith} | ${p(withViewers, 0.5)} | ${p(withViewers, 0.99)} | ${range(worst.withViewers)} | ${(pictures / VIEWERS / ROUNDS / (BLOCK_S + 1)).toFixed(1)} |`);
  console.log(`| change | | | ${change(0.5)} | ${change(0.99)} | | |`);

  const calm = await answers(500);
  const idle = await idleConnections(200);
  const slow = slowReader();
  await pause(2000);
  const busy = await answers(500);
  console.log('\n| `GET /api/status` | p50, ms | p99, ms |\n|---|---:|---:|');
  console.log(`| alone | ${p(calm, 0.5)} | ${p(calm, 0.99)} |`);
  console.log(`| beside ${idle.length} idle connections and a reader of pictures that reads nothing | ${p(busy, 0.5)} | ${p(busy, 0.99)} |`);
  for (const socket of [...idle, slow]) socket.destroy();
} finally {
  packets.close();
  await service.end();
}
