// SPDX-License-Identifier: Apache-2.0
// Latency of the panel's live image: from capture to the paint in Chromium, on loopback and through a link of 8 Mbit/s.
//   node tests/figures/preview_latency.mjs [seconds each, 15]
// Prints Markdown; exit code 1 if a limit is exceeded. Environment: SSLV_DAEMON, SSLV_CHROMIUM.
// Not part of the tests, as it also measures the machine.
import { readdirSync, readFileSync } from 'node:fs';
import { loadavg } from 'node:os';
import { join } from 'node:path';
import { setTimeout as pause } from 'node:timers/promises';
import { gzipSync } from 'node:zlib';
import { launch } from '../e2e/browser.mjs';
import { createService, root } from '../e2e/service.mjs';
import { createLink } from '../e2e/slow_link.mjs';

const SECONDS = Number(process.argv[2] ?? 15);
const LINK_KBPS = 8000;
const FIRST_PICTURE_MS = 2000;
const FIRST_LOAD_BYTES = 120e3;

/** Runs in the page before its own code: records the capture and paint times of each image. Service and browser
 * share a clock. */
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
      // The task after the paint of this frame.
      setTimeout(() => {
        const captured = taken.get(frame);
        if (captured !== undefined) window.pictures.push({ at: performance.now(), delayMs: Date.now() - captured * 1000, width: target.width });
      });
    }
  }).observe(document, { subtree: true, attributes: true, attributeFilter: ['data-frame'] });
}

const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

async function measure(browser, address) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.addInitScript(watchPictures);
  await page.goto(address('#/camera/0'));
  await page.waitForFunction(() => window.pictures.length > 0);
  const firstMs = await page.evaluate(() => window.pictures[0].at);
  // Lets the page settle: settings, first adaptation.
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
  // The files that the Camera page loads: the entry and its own chunk; other pages' chunks load when they are opened.
  const needed = readdirSync(join(dist, 'assets')).filter((file) => /^(index|CameraPage)-.*\.(js|css)$/.test(file)).map((file) => join('assets', file));
  return ['index.html', 'theme.js', ...needed].reduce((sum, file) => sum + gzipSync(readFileSync(join(dist, file))).length, 0);
}

const service = await createService('239.255.77.82');
let browser = null;
let link = null;
let failed = false;
try {
  await service.start();
  browser = await launch();
  link = await createLink(() => service.settings.panel.port, { slice_ms: 1, burst_ms: 4 });
  link.limit(LINK_KBPS);
  const rows = [
    { name: 'loopback', limit: 60, ...await measure(browser, service.address) },
    { name: '8 Mbit/s', limit: 150, ...await measure(browser, link.address) },
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
  await link?.end();
  await browser?.close();
  await service.end();
}
if (failed) {
  console.error('A limit was missed.');
  process.exitCode = 1;
}
