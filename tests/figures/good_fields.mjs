// SPDX-License-Identifier: Apache-2.0
// Checks that the verdict raises no false alarms: fields with many seeds, sizes, lights, carpets and numbers of
// cameras, set up like an admin would, then watched. Prints a Markdown table; exit code 1 if a field is not GO or has a
// warning.
//   node good_fields.mjs [--fields 50] [--first 1] [--minutes 10] [--at-once 1] [--rate 10] [--drawn]
// --drawn: images from the renderer of tests/halls, which shares no code with the simulator, of one camera over one
// half. Two alerts are then allowed: the other half is uncovered, and robots that drive there are lost.
import { createSocket } from 'node:dgram';
import { execFileSync } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as pause } from 'node:timers/promises';
import { parseArgs } from 'node:util';
import { gameController } from '../e2e/league_messages.mjs';
import { becomes, createService, DAEMON, freeUdpPort } from '../e2e/service.mjs';

const { values: options } = parseArgs({ options: {
  fields: { type: 'string', default: '50' }, first: { type: 'string', default: '1' }, minutes: { type: 'string', default: '10' },
  'at-once': { type: 'string', default: '1' }, rate: { type: 'string', default: '10' }, drawn: { type: 'boolean', default: false },
} });
const [FIELDS, FIRST, MINUTES, AT_ONCE, RATE_HZ] = ['fields', 'first', 'minutes', 'at-once', 'rate'].map((name) => Number(options[name]));
const GRIDS = { 1: [1, 1], 2: [2, 1], 3: [3, 1], 4: [2, 2], 6: [3, 2], 8: [4, 2] };
const HEIGHT_MM = 4000, MM_SEEN_BESIDE = 350;
// The resolution of the league's coarser fields. Two by two pixels of a Bayer image make one colour pixel.
const MM_PER_PX = { uyvy: 7.5, rgb24: 7.5, bayer_rg8: 3.75 };
// By default the lamps of a usual hall vary by a third per image, for tests of learning: not a good field.
const LAMPS = { flicker_low: 0.95, flicker_high: 1.05 };
const STAGE_PLAYED = 1, NORMAL_START = 2;
// Caused by this computer, not the field: packets stay on it, and it runs several services at a time.
const OF_THE_COMPUTER = new Set(['only_this_computer', 'frames_dropped', 'latency_high', 'stage_slow', 'camera_slow']);
const CHECKS_OF_THE_COMPUTER = new Set(['network', 'computer', 'clock', 'pictures', 'latency', 'cameras']);
const DRAWN_FRAMES = 120;
const MINUTE_MS = 60e3;

/** Reproducible random numbers (mulberry32). */
function chances(seed) {
  let state = seed * 0x9e3779b9;
  const next = () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
  next();
  const between = (low, high) => low + (high - low) * next();
  return { between, whole: (low, high) => Math.floor(between(low, high + 1)), one: (list) => list[Math.floor(next() * list.length)] };
}

/** The vector rotated by the unit quaternion [x, y, z, w]. */
function turned([x, y, z, w], [a, b, c]) {
  const t = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * t[0] + y * t[2] - z * t[1], b + w * t[1] + z * t[0] - x * t[2], c + w * t[2] + x * t[1] - y * t[0]];
}

/** A grid of cameras that look straight down; each also sees a little beyond the carpet or of its neighbours' parts. */
function camerasOf(chance, count, field, source, classes) {
  const [columns, rows] = GRIDS[count];
  const length = field.field_length + 2 * field.boundary_width_goal_line, width = field.field_width + 2 * field.boundary_width;
  const seen = [length / columns + 2 * MM_SEEN_BESIDE, width / rows + 2 * MM_SEEN_BESIDE];
  // Even numbers, as required by formats with pixel pairs.
  const mmPerPx = MM_PER_PX[source.pixel_format];
  const [high, wide] = seen.map((mm) => 2 * Math.round(mm / mmPerPx / 2));
  const height = HEIGHT_MM * chance.between(0.95, 1.1);
  return Array.from({ length: count }, (_, id) => {
    const place = [((id % columns) + 0.5) * (length / columns) - length / 2, (Math.floor(id / columns) + 0.5) * (width / rows) - width / 2, height];
    // Downwards, with the image's x axis along the field's y axis and a slight misalignment, as in real halls.
    const q = [Math.SQRT1_2 + chance.between(-1e-2, 1e-2), -Math.SQRT1_2 + chance.between(-1e-2, 1e-2), chance.between(-1e-2, 1e-2), chance.between(-1e-2, 1e-2)];
    const norm = Math.hypot(...q);
    const unit = q.map((one) => one / norm);
    const [tx, ty, tz] = turned(unit, place).map((one) => -one);
    return {
      id, name: `camera ${id}`, source: { ...source, width: wide, height: high },
      calibration: {
        focal_length: height / mmPerPx, principal_point_x: wide / 2 + chance.between(-4, 4), principal_point_y: high / 2 + chance.between(-4, 4), distortion: chance.between(0, 0.1),
        q0: unit[0], q1: unit[1], q2: unit[2], q3: unit[3], tx, ty, tz, pixel_image_width: wide, pixel_image_height: high,
      },
      colors: { classes },
    };
  });
}

/** Operations on the service of one field: requests, learning colours, watching the verdict. */
function adminOf(service) {
  const ask = async (path) => (await fetch(service.address(`api/${path}`))).json();
  let hasLearnt = false;
  return {
    ask,
    async learnColors(id) {
      hasLearnt = true;
      const learning = async (method, path = '') => (await fetch(service.address(`api/cameras/${id}/colors/learning${path}`), { method })).json();
      // Retry until robots are in view of this camera, as an admin would.
      await becomes(async () => {
        await learning('POST');
        return becomes(() => learning('GET'), ({ state }) => state === 'done' || state === 'failed');
      }, ({ state, report }) => state === 'done' && report.learnt);
      await learning('POST', '/accept');
    },
    /** Collects what the verdict reports against the field after GO (or after an admin's patience): `said`, with
     * counts. */
    async watch(isExpected = () => false) {
      // Colour problems from before the learning are still reported for the images of the last minute.
      if (hasLearnt) await pause(MINUTE_MS);
      const until = Date.now() + 15_000;
      while (Date.now() < until && (await ask('status')).checks.some(({ state }) => state === 'fail')) await pause(500);
      await pause(8000);
      const said = new Map(), busy = new Set();  // said: text by alert id and camera
      const count = (which, what) => said.set(which, { what, times: (said.get(which)?.times ?? 0) + 1 });
      let looks = 0;
      for (const end = Date.now() + MINUTES * MINUTE_MS; Date.now() < end; await pause(1000)) {
        const { alerts, checks } = await ask('status');
        ++looks;
        for (const { id, camera, title, severity } of alerts) {
          if (OF_THE_COMPUTER.has(id)) busy.add(id);
          else if (severity !== 'info' && !isExpected({ id, title })) count(`${id} ${camera}`, title);
        }
        for (const { id, state, text } of checks) {
          if (state === 'pass' || state === 'unknown' || CHECKS_OF_THE_COMPUTER.has(id) || alerts.some(({ check, title }) => check === id || text.startsWith(title))) continue;
          count(id, `${id} ${state}: ${text}`);
        }
      }
      return { said, busy, looks };
    },
  };
}

function row(text, { said, busy, looks }) {
  const against = [...said.values()].map(({ what, times }) => `${what} (${times} of ${looks})`).join('; ');
  console.log(`| ${text} | ${looks} | ${against || 'nothing'}${busy.size ? ` (computer: ${[...busy].join(', ')})` : ''} |`);
  return said.size === 0;
}

const notSetUp = (error) => ({ said: new Map([['', { what: `not set up: ${error.message.slice(0, 300)}`, times: 1 }]]), busy: new Set(), looks: 0 });

/** Watches a simulated field; returns whether the verdict reported nothing against it. */
async function watchSimulated(seed) {
  const chance = chances(seed);
  const service = await createService(`239.255.78.${seed % 250}`);
  const count = chance.one(Object.keys(GRIDS).map(Number));
  const preset = chance.one(['division-a', 'division-b']);
  const kind = chance.one(['plain', 'plain', 'usual']);
  // Brighter light would over-expose a usual hall's boards and lines; an admin would then set the exposure.
  const light = chance.between(0.7, 1.2);
  const robots = chance.whole(3, preset === 'division-a' ? 11 : 6);
  const match = chance.one(['nobody', 'before', 'played']);
  const [first] = service.settings.cameras;
  const gcPort = await freeUdpPort();
  service.settings.network.referee = { enabled: match !== 'nobody', group: `239.255.79.${seed % 250}`, port: gcPort, interface: 'lo' };
  service.settings.cameras = [];
  const text = `${seed} | ${count} | ${preset.at(-1).toUpperCase()} | ${kind} | ${light.toFixed(2)} | ${robots} + ${robots} | ${match}`;
  const socket = createSocket('udp4').bind(0, '127.0.0.1');
  await once(socket, 'listening');
  socket.setMulticastInterface('127.0.0.1');
  const team = ['', robots];
  const packet = gameController({ yellow: team, blue: team, ...(match === 'played' ? { stage: STAGE_PLAYED, command: NORMAL_START } : {}) });
  // Starts after the setup: settings are locked once the match is played.
  const beginMatch = () => match === 'nobody' ? null : setInterval(() => socket.send(packet, gcPort, service.settings.network.referee.group), 100);
  let seen, sending = null;
  try {
    await service.start();
    const { ask, learnColors, watch } = adminOf(service);
    const { field } = (await ask('field/presets')).find(({ name }) => name === preset);
    const source = {
      backend: 'simulator', pixel_format: chance.one(['uyvy', 'bayer_rg8', 'rgb24']), frame_rate_hz: RATE_HZ, robots_yellow: robots, robots_blue: robots, balls: 1, seed,
      noise_sigma: chance.between(1, 4), vignette: chance.between(0, 0.2), gradient: chance.between(0, 0.25), light, speed: chance.one([0.3, 0.6, 1]), hall: { kind, seed, lamps: LAMPS },
    };
    const cameras = camerasOf(chance, count, field, source, first.colors.classes);
    await service.patch({ op: 'replace', path: '/field', value: field }, { op: 'replace', path: '/cameras', value: cameras });
    await service.statusBecomes((now) => now.cameras.length === count && now.cameras.every(({ frames }) => frames > 5));
    if (kind !== 'plain') {
      for (const { id } of cameras) await learnColors(id);
    }
    sending = beginMatch();
    seen = await watch();
  } catch (error) {
    seen = notSetUp(error);
  } finally {
    clearInterval(sending);
    socket.close();
    await service.end();
  }
  return row(text, seen);
}

/** Names of robots ("yellow 8") that are not always visible in a drawn recording. */
function leavingRobots(folder) {
  const frames = readFileSync(join(folder, 'truth.jsonl'), 'utf8').trim().split('\n').map((line) => JSON.parse(line));
  return new Set(frames.flatMap(({ robots }) => robots.filter(({ visible }) => !visible).map(({ team, id }) => `${team} ${id}`)));
}
/** The robots named in a title such as "yellow 0, 3 and blue 7 are no longer seen". */
const namedIn = (title) => [...title.split(/ (?:is|are) /)[0].matchAll(/(yellow|blue) ([\d, ]+)/g)].flatMap(([, team, ids]) => ids.split(',').map((id) => `${team} ${Number(id)}`));

/** Watches a hall of the other renderer; returns whether only the uncovered half was reported. */
async function watchDrawn(seed) {
  const chance = chances(seed);
  const [kind, size, format] = [chance.one(['usual', 'usual', 'hard']), chance.one(['A', 'B']), chance.one(['uyvy', 'rgb24', 'bayer_rg8'])];
  const robots = chance.whole(3, 8);
  const folder = mkdtempSync(join(tmpdir(), 'ssl-visiond-hall.'));
  const service = await createService(`239.255.78.${seed % 250}`);
  let seen;
  try {
    execFileSync(join(DAEMON, '../draw_halls'), ['--kind', kind, '--size', size, '--format', format, '--seed', seed, '--robots', robots, '--placement', 'paths', '--frames', DRAWN_FRAMES, '--output', folder]);
    const { field, teams, cameras: [camera] } = JSON.parse(readFileSync(join(folder, 'settings.json'), 'utf8'));
    const [{ colors: { classes } }] = service.settings.cameras;
    Object.assign(service.settings, { field, teams });
    service.settings.cameras = [{ ...camera, source: { ...camera.source, path: folder, frame_rate_hz: RATE_HZ, loop: true }, colors: { classes } }];
    await service.start();
    const { learnColors, watch } = adminOf(service);
    await service.statusBecomes((now) => now.cameras.every(({ frames }) => frames > 5));
    await learnColors(0);
    const leave = leavingRobots(folder);
    seen = await watch(({ id, title }) => id === 'field_uncovered' || (id === 'robots_lost' && namedIn(title).every((name) => leave.has(name))));
  } catch (error) {
    seen = notSetUp(error);
  } finally {
    await service.end();
    rmSync(folder, { recursive: true });
  }
  return row(`${seed} | 1 | ${size} | drawn, ${kind}, ${format} | | ${robots} + ${robots} | nobody`, seen);
}

console.log('| seed | cameras | field | hall | light | robots | game controller | looks | said against it |');
console.log('|---:|---:|---|---|---:|---|---|---:|---|');
const seeds = Array.from({ length: FIELDS }, (_, i) => FIRST + i);
let bad = 0;
await Promise.all(Array.from({ length: AT_ONCE }, async () => {
  for (let seed = seeds.shift(); seed !== undefined; seed = seeds.shift()) if (!(await (options.drawn ? watchDrawn : watchSimulated)(seed))) ++bad;
}));
console.log(`\n${FIELDS} fields, ${MINUTES} min each: ${bad} of them not left alone`);
process.exitCode = bad ? 1 : 0;
