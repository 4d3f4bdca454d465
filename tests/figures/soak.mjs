// SPDX-License-Identifier: Apache-2.0
// Condensed long-term operation: four cameras, viewers that connect and disconnect, changes of settings and colours, a
// camera that is reopened repeatedly. Prints a Markdown table; exit code 1 if memory, threads or descriptors grow or a
// frame is lost.
//   node soak.mjs [--minutes 10] [--rate 60]
import { readdirSync, readFileSync } from 'node:fs';
import { setTimeout as pause } from 'node:timers/promises';
import { parseArgs } from 'node:util';
import { createService } from '../e2e/service.mjs';
import { largerCamera, receivePackets } from './packets.mjs';
import { openViewer } from './viewer.mjs';

const { values: options } = parseArgs({ options: { minutes: { type: 'string', default: '10' }, rate: { type: 'string', default: '60' } } });
const MINUTES = Number(options.minutes), RATE_HZ = Number(options.rate);
const MOST_GROWTH = 0.01;
const SAMPLE_MS = 2000;
/** The camera that is reopened repeatedly; the others must not be affected. */
const RESTLESS = 3;
// Long enough for the settings' history, the log and the timeline to reach their full size.
const WARM_UP = 0.4;

const service = await createService('239.255.77.93');
const [left, right] = service.settings.cameras.map(largerCamera);
service.settings.cameras = [0, 1, 2, 3].map((id) => {
  const camera = structuredClone(id % 2 ? right : left);
  return { ...camera, id, name: `camera ${id}`, source: { ...camera.source, seed: id + 1, frame_rate_hz: RATE_HZ } };
});
const packets = await receivePackets(service);
const proc = (name) => readFileSync(`/proc/${service.pid()}/${name}`, 'utf8');

function sample() {
  const status = proc('status');
  const number = (key) => Number(new RegExp(`^${key}:\\s+(\\d+)`, 'm').exec(status)[1]);
  return { memory: number('VmRSS'), threads: number('Threads'), descriptors: readdirSync(`/proc/${service.pid()}/fd`).length };
}

async function call(method, path, body) {
  const answer = await fetch(service.address(`api/${path}`), { method, body: body && JSON.stringify(body) });
  if (!answer.ok) throw new Error(`${method} ${path}: ${await answer.text()}`);
  return answer.json();
}
const counts = { viewers: 0, pictures: 0, edits: 0, strokes: 0, reopenings: 0 };
let ending = false;
const untilTheEnd = async (work) => { while (!ending) await work(); };

/** Five viewers, each connected for a second or two, alternating between the kinds of image. */
const viewers = (which) => untilTheEnd(async () => {
  const kinds = ['camera', 'labels'];
  const viewer = await openViewer(service.settings.panel.port, { camera: which % 4, width: 640, quality: 70, fps: 15, picture: kinds[counts.viewers % 2], regions: true });
  counts.viewers++;
  await pause(1000 + which * 300);
  counts.pictures += viewer.pictures;
  viewer.end();
});
const edits = () => untilTheEnd(async () => {
  const n = counts.edits++;
  await call('PATCH', 'settings', [
    { op: 'replace', path: '/site', value: `Hall ${n}` },
    { op: 'replace', path: '/cameras/0/stages/detect_balls/min_confidence', value: 0.1 + 0.01 * (n % 10) },
  ]);
  if (n % 20 === 0) await call('PUT', `profiles/${encodeURIComponent(`profile ${n % 5}`)}`);
  await call('GET', 'status');
  await call('GET', 'settings/history');
  await pause(50);
});
const strokes = () => untilTheEnd(async () => {
  const n = counts.strokes++;
  await call('POST', 'cameras/1/colors/edits', { commands: [{ op: 'paint', label: 'black', shape: 'box', at: [20, 40 + (n % 20), 40], radius: [1, 1, 1] }] });
  await pause(400);
});
const reopenings = () => untilTheEnd(async () => {
  await call('PATCH', 'settings', [{ op: 'replace', path: `/cameras/${RESTLESS}/source/seed`, value: 10 + (counts.reopenings++ % 100) }]);
  await service.statusBecomes(({ cameras }) => cameras[RESTLESS].state === 'running');
  await pause(3000);
});

/** Number of frames of each camera that did not reach the teams. */
function missingFrames(frames) {
  const last = new Map(), missing = [0, 0, 0, 0];
  for (const { camera, number } of frames) {
    if (last.has(camera) && number > last.get(camera) + 1) missing[camera] += number - last.get(camera) - 1;
    last.set(camera, number);
  }
  return missing;
}

try {
  await service.start();
  await service.statusBecomes(({ cameras }) => cameras.every(({ frames }) => frames > 100));
  const before = (await call('GET', 'status')).cameras;
  const samples = [];
  const frames = packets.block(MINUTES * 60);
  const work = [...[0, 1, 2, 3, 4].map(viewers), edits(), strokes(), reopenings()];
  const start = Date.now();
  while (Date.now() - start < MINUTES * 60e3) {
    samples.push({ share: (Date.now() - start) / (MINUTES * 60e3), ...sample() });
    await pause(SAMPLE_MS);
  }
  const seen = await frames;
  ending = true;
  await Promise.all(work);
  const after = (await call('GET', 'status')).cameras;

  const settled = samples.filter(({ share }) => share >= WARM_UP);
  const third = Math.floor(settled.length / 3);
  const mean = (list, key) => list.reduce((sum, one) => sum + one[key], 0) / list.length;
  const least = (list, key) => Math.min(...list.map((one) => one[key]));
  let failed = false;
  const verdict = (isGood) => { failed ||= !isGood; return isGood ? 'yes' : '**no**'; };
  console.log(`Four cameras, 1280 x 1024, ${RATE_HZ} Hz, ${MINUTES} min: ${counts.viewers} viewers came and went (${counts.pictures} pictures), ${counts.edits} changes of settings, ${counts.strokes} of a colour table, ${counts.reopenings} reopenings of camera ${RESTLESS}\n`);
  console.log('| | after the warm-up | at the end | growth | within 1 % |\n|---|---:|---:|---:|---|');
  for (const [key, unit] of [['memory', ' kB'], ['threads', ''], ['descriptors', '']]) {
    // Connections open and close, so the minimum shows how many descriptors and threads remain.
    const measure = key === 'memory' ? mean : least;
    const first = measure(settled.slice(0, third), key), last = measure(settled.slice(-third), key);
    const growth = last / first - 1;
    console.log(`| ${key} | ${first.toFixed(0)}${unit} | ${last.toFixed(0)}${unit} | ${(growth * 100).toFixed(2)} % | ${verdict(growth <= MOST_GROWTH)} |`);
  }
  console.log('\n| camera | frames sent | missing on the wire | came and not processed | damaged | none lost |\n|---|---:|---:|---:|---:|---|');
  const missing = missingFrames(seen);
  for (const camera of after) {
    const old = before.find(({ id }) => id === camera.id);
    const dropped = camera.frames_dropped - old.frames_dropped, damaged = camera.frames_incomplete - old.frames_incomplete;
    const isGood = dropped === 0 && damaged === 0 && (camera.id === RESTLESS || missing[camera.id] === 0);
    const sent = seen.filter((frame) => frame.camera === camera.id).length;
    console.log(`| ${camera.id}${camera.id === RESTLESS ? ', reopened' : ''} | ${sent} | ${missing[camera.id]} | ${dropped} | ${damaged} | ${verdict(isGood)} |`);
  }
  process.exitCode = failed ? 1 : 0;
} finally {
  ending = true;
  packets.close();
  await service.end();
}
