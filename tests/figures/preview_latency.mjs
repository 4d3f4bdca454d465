// SPDX-License-Identifier: Apache-2.0
// How late the panel's live picture is: from capture to the paint in Chromium, on loopback and through a link of 8 Mbit/s.
//   node tests/figures/preview_latency.mjs [seconds each, 15]
// Prints Markdown; exit 1 when a limit is missed. Environment: SSLV_DAEMON, SSLV_CHROMIUM. Not among the tests: it measures the machine too.
import { readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { createConnection, createServer } from 'node:net';
import { loadavg } from 'node:os';
import { join } from 'node:path';
import { once } from 'node:events';
import { setTimeout as pause } from 'node:timers/promises';
import { gzipSync } from 'node:zlib';
import { createService, root } from '../e2e/service.mjs';

const require = createRequire(join(root, 'webui/package.json'));
const { chromium } = require('playwright-core');

const SECONDS = Number(process.argv[2] ?? 15);
const LINK_BITS_PER_S = 8e6;
const FIRST_PICTURE_MS = 2000;
const FIRST_LOAD_BYTES = 300e3;

/** Bytes that may pass now; grows with time, up to a millisecond's bursts. */
class TokenBucket {
  constructor(bitsPerS) {
    this.bytesPerMs = bitsPerS / 8000;
    this.most = 4 * this.bytesPerMs;
    this.tokens = this.most;
    this.at = performance.now();
  }

  take(wanted) {
    const at = performance.now();
    this.tokens = Math.min(this.most, this.tokens + (at - this.at) * this.bytesPerMs);
    this.at = at;
    const taken = Math.min(wanted, Math.floor(this.tokens));
    this.tokens -= taken;
    return taken;
  }
}

/** One direction of one connection: reads no more than 64 KiB ahead of what the link has carried. */
class Pipe {
  static MOST = 64 * 1024;
  queue = [];
  bytes = 0;

  constructor(bucket) { this.bucket = bucket; }

  read(buffer, from) {
    this.queue.push(Buffer.from(buffer));
    this.bytes += buffer.length;
    if (this.bytes < Pipe.MOST) return true;
    this.stopped = from;
    return false;
  }

  carry(to) {
    while (this.queue.length && to.writable) {
      const [first] = this.queue;
      const taken = this.bucket.take(first.length);
      if (!taken) return;
      to.write(first.subarray(0, taken));
      if (taken < first.length) this.queue[0] = first.subarray(taken);
      else this.queue.shift();
      this.bytes -= taken;
      if (this.stopped && this.bytes < Pipe.MOST / 2) {
        this.stopped.resume();
        this.stopped = null;
      }
    }
  }
}

/** A link to `port` that all connections through it share. Sockets are read in pieces of 16 KiB. */
async function startLink(port, bitsPerS) {
  const [down, up] = [new TokenBucket(bitsPerS), new TokenBucket(bitsPerS)];
  const sockets = new Set();
  const server = createServer({ highWaterMark: 16 * 1024, noDelay: true, pauseOnConnect: true }, (client) => {
    const toClient = new Pipe(down);
    const toService = new Pipe(up);
    const service = createConnection({
      port, host: '127.0.0.1', noDelay: true,
      onread: { buffer: Buffer.alloc(16 * 1024), callback: (size, buffer) => toClient.read(buffer.subarray(0, size), service) },
    });
    client.on('data', (data) => { if (!toService.read(data, client)) client.pause(); });
    client.resume();
    const timer = setInterval(() => {
      toClient.carry(client);
      toService.carry(service);
    }, 1);
    const end = () => {
      clearInterval(timer);
      client.destroy();
      service.destroy();
      sockets.delete(client);
    };
    for (const socket of [client, service]) socket.on('error', end).on('close', end);
    sockets.add(client);
  });
  server.listen(0, '127.0.0.1');
  await once(server, 'listening');
  return { port: server.address().port, end: () => { sockets.forEach((socket) => socket.destroy()); server.close(); } };
}

/** In the page, before its own code: notes when each picture was taken, and when it was painted. Service and browser share a clock here. */
function watchPictures() {
  const taken = new Map();
  window.pictures = [];
  window.bytes = 0;
  const Plain = window.WebSocket;
  window.WebSocket = class extends Plain {
    constructor(...args) {
      super(...args);
      this.addEventListener('message', ({ data }) => {
        window.bytes += data.byteLength ?? data.length;
        if (typeof data === 'string') return;
        const length = new DataView(data).getUint32(0, true);
        const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
        taken.set(String(header.frame), header.t_capture);
      });
    }
  };
  new MutationObserver((changes) => {
    for (const { target } of changes) {
      const frame = target.dataset.frame;
      // The task after the paint of this very frame.
      setTimeout(() => {
        const captured = taken.get(frame);
        if (captured !== undefined) window.pictures.push({ at: performance.now(), delayMs: Date.now() - captured * 1000, width: target.width });
      });
    }
  }).observe(document, { subtree: true, attributes: true, attributeFilter: ['data-frame'] });
}

const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

async function measure(browser, port) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.addInitScript(watchPictures);
  await page.goto(`http://127.0.0.1:${port}/#/camera/0`);
  await page.waitForFunction(() => window.pictures.length > 0);
  const firstMs = await page.evaluate(() => window.pictures[0].at);
  // The page settles: settings, first adaptation.
  await pause(3000);
  await page.evaluate(() => { window.pictures.length = 0; window.bytes = 0; window.from = performance.now(); });
  await pause(SECONDS * 1000);
  const { pictures, bytes, lasted } = await page.evaluate(() => ({ pictures: window.pictures, bytes: window.bytes, lasted: (performance.now() - window.from) / 1000 }));
  await context.close();
  const delays = pictures.map(({ delayMs }) => delayMs).sort((a, b) => a - b);
  if (!delays.length) throw new Error('no picture came while it was measured');
  return {
    firstMs, p50: quantile(delays, 0.5), p95: quantile(delays, 0.95), most: delays.at(-1),
    fps: delays.length / lasted, mbit: (bytes * 8) / 1e6 / lasted, width: pictures.at(-1).width,
  };
}

function firstLoadBytes() {
  const dist = join(root, 'webui/dist');
  // What the Camera page loads: the start and its own part; other pages' parts come when they are opened.
  const needed = readdirSync(join(dist, 'assets')).filter((file) => /^(index|CameraPage)-.*\.(js|css)$/.test(file)).map((file) => join('assets', file));
  return ['index.html', 'theme.js', ...needed].reduce((sum, file) => sum + gzipSync(readFileSync(join(dist, file))).length, 0);
}

const service = await createService('239.255.77.82');
let browser = null;
let link = null;
let failed = false;
try {
  await service.start();
  browser = await chromium.launch({ executablePath: process.env.SSLV_CHROMIUM ?? '/usr/bin/chromium', chromiumSandbox: process.getuid() !== 0, args: ['--disable-gpu'] });
  link = await startLink(service.settings.panel.port, LINK_BITS_PER_S);
  const rows = [
    { name: 'loopback', limit: 60, ...await measure(browser, service.settings.panel.port) },
    { name: '8 Mbit/s', limit: 150, ...await measure(browser, link.port) },
  ];
  const bytes = firstLoadBytes();
  const load = loadavg()[0].toFixed(1);
  console.log('| link | first picture ms | p50 ms | p95 ms | longest ms | limit of p95 ms | fps | Mbit/s | width px |');
  console.log('|---|---|---|---|---|---|---|---|---|');
  for (const { name, limit, firstMs, p50, p95, most, fps, mbit, width } of rows) {
    console.log(`| ${name} | ${firstMs.toFixed(0)} | ${p50.toFixed(0)} | ${p95.toFixed(0)} | ${most.toFixed(0)} | ${limit} | ${fps.toFixed(1)} | ${mbit.toFixed(2)} | ${width} |`);
    if (p95 >= limit || firstMs >= FIRST_PICTURE_MS) failed = true;
  }
  console.log(`\nFirst load of the Camera page: ${(bytes / 1000).toFixed(0)} kB gzipped. Load of the machine: ${load}.`);
  if (bytes >= FIRST_LOAD_BYTES) failed = true;
} finally {
  link?.end();
  await browser?.close();
  await service.end();
}
if (failed) {
  console.error('A limit was missed.');
  process.exitCode = 1;
}
