// SPDX-License-Identifier: Apache-2.0
// SIGTERM stops the service cleanly whatever it is doing, without finishing that first.
//   SSLV_STOP_TRIES  how often it is stopped during each activity; default: 1
//   SSLV_STOP_TABLE  a file to which a Markdown table row is appended for each activity: how long stopping took
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { once } from 'node:events';
import { appendFileSync, closeSync, constants, copyFileSync, existsSync, linkSync, mkdirSync, openSync, readdirSync, readFileSync, readlinkSync, writeFileSync } from 'node:fs';
import { connect } from 'node:net';
import { join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { deflateSync, gzipSync } from 'node:zlib';
import { openViewer } from '../figures/viewer.mjs';
import { crc32, readClip } from './clip_reader.mjs';
import { becomes, createService, PATIENCE_MS, root } from './service.mjs';

const TRIES = Number(process.env.SSLV_STOP_TRIES ?? 1);
const LIBRARIES = process.env.SSLV_KIT_LIBRARIES ?? join(root, 'build/release/kit');
const service = await createService('239.255.77.94');
// Close enough for both cameras to see the same robots.
service.settings.cameras.forEach(({ calibration }, i) => { calibration.ty = i === 0 ? -2000 : 2000; });
const recordings = join(service.stateFolder, 'recordings'), kept = join(service.folder, 'kept');

const ask = async (method, path, body) => {
  const answer = await fetch(service.address(`api/${path}`), { method, body: body && JSON.stringify(body) });
  const text = await answer.text();
  assert.ok(answer.ok, `${method} ${path}: ${answer.status} ${text}`);
  return JSON.parse(text);
};
/** Ignores failures of a request that may be pending when the service stops. */
const leaveOpen = (promise) => promise.catch(() => {});
const cameraRuns = () => service.statusBecomes(({ cameras }) => cameras.every(({ state, fps }) => state === 'running' && fps > 0));
/** Starts an activity repeatedly until it is observed in progress, as it may finish too soon. */
async function isCaught(begin, look, wanted, isOver) {
  for (;;) {
    await begin();
    for (;;) {
      const now = await look();
      if (wanted(now)) return;
      if (isOver(now)) break;
      await pause(2);
    }
  }
}
const solves = (begin, path) => isCaught(begin, () => ask('GET', path), ({ state }) => state === 'solving', ({ state }) => !['collecting', 'solving'].includes(state));
const inProcess = (what, read) => readdirSync(`/proc/${service.pid()}/${what}`).map((name) => {
  try {
    return read(`/proc/${service.pid()}/${what}/${name}`);
  } catch {
    return ''; // it has ended
  }
});
const hasOpen = (file) => becomes(() => inProcess('fd', readlinkSync), (files) => files.includes(file));
/** A connection on which a request was sent; the answer is read only if the caller does so. */
async function said(text) {
  const socket = connect(service.settings.panel.port, '127.0.0.1');
  socket.on('error', () => {}); // the service stops
  await once(socket, 'connect');
  socket.write(text);
  return socket;
}
const httpHead = (method, path, length = 0) => `${method} /${path} HTTP/1.1\r\nHost: 127.0.0.1:${service.settings.panel.port}\r\nContent-Length: ${length}\r\n\r\n`;
const silentSource = (id) => {
  const pipe = join(service.folder, `${id}.mp4`);
  if (!existsSync(pipe)) execFileSync('mkfifo', [pipe]);
  return { backend: 'files', path: pipe };
};
/** Waits until the service opens this pipe; reading then blocks until the returned function closes it. */
const isWaitedFor = async ({ path }) => {
  let end = null;
  await becomes(() => {
    try {
      end = openSync(path, constants.O_WRONLY | constants.O_NONBLOCK);
    } catch (error) {
      assert.equal(error.code, 'ENXIO', 'nobody opens it');
    }
    return end;
  }, (there) => there !== null);
  return () => closeSync(end);
};
/** Corners of the half field that camera 0 sees; one is wrong, which makes the calibration search. */
const POINTS = [[120, 90], [660, 100], [110, 480], [670, 490], [390, 90], [395, 300], [250, 200]].map(([x, y]) => ({ x, y }));

/** A log packed in gzip members as by other programs: `parts` members of `megabytes` each. */
function writeLongLog(file, parts, megabytes) {
  const message = Buffer.alloc(16 + 1008);
  message.writeInt32BE(1, 8);
  message.writeInt32BE(1008, 12);
  const head = Buffer.concat([Buffer.from('SSL_LOG_FILE'), Buffer.from([0, 0, 0, 1])]);
  const messages = Buffer.alloc(megabytes << 20, message);
  writeFileSync(file, gzipSync(Buffer.concat([head, messages]), { level: 1 }));
  const more = parts > 1 ? gzipSync(messages, { level: 1 }) : null;
  for (let i = 1; i < parts; i++) appendFileSync(file, more);
}

/** The largest image allowed, quick to upload. */
function largeImage() {
  const [width, height] = [8000, 4000];
  const chunk = (name, bytes) => {
    const named = Buffer.concat([Buffer.from(name), bytes]);
    const number = (value) => { const out = Buffer.alloc(4); out.writeUInt32BE(value); return out; };
    return Buffer.concat([number(bytes.length), named, number(crc32(named))]);
  };
  const size = Buffer.alloc(13);
  size.writeUInt32BE(width, 0);
  size.writeUInt32BE(height, 4);
  size.set([8, 2], 8);
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), chunk('IHDR', size), chunk('IDAT', deflateSync(Buffer.alloc((3 * width + 1) * height, 7), { level: 1 })), chunk('IEND', Buffer.alloc(0))]);
}

/** Writes a clip that takes long to compare: its frames repeated, without an end block. */
function writeLongClip(from, to) {
  const file = readFileSync(from);
  const frames = [];
  let begin = 0;
  for (let place = 16; place < file.length - 16;) {
    const end = place + 32 + Math.ceil(Number(file.readBigUInt64LE(place + 8)) / 8) * 8;
    if (file.readUInt32LE(place) === 3 && file.readUInt32LE(place + 4) === 0) frames.push(file.subarray(place, end));
    else if (file.readUInt32LE(place) < 3) begin = Math.max(begin, end);
    place = end;
  }
  writeFileSync(to, file.subarray(0, begin));
  for (let i = 0; i < 300; i += frames.length) appendFileSync(to, Buffer.concat(frames));
}
const clips = () => ask('GET', 'recordings/clips');
const newestClip = async () => (await becomes(clips, ({ clip, clips: all }) => clip.state === 'idle' && all.some(({ begin_s: s }) => s !== null))).clips[0];

/** Each gets the service into the middle of an activity; the returned function is called after it has stopped. */
const activities = {
  'nothing special': async () => { await cameraRuns(); },
  'the calibration of a camera, collecting': async () => {
    await cameraRuns();
    await ask('POST', 'cameras/0/calibration', { points: POINTS, frames: 100 });
    await becomes(() => ask('GET', 'cameras/0/calibration'), ({ state, frames_taken: frames }) => state === 'collecting' && frames > 0);
  },
  'the calibration of a camera, solving': async () => {
    await cameraRuns();
    await solves(() => ask('POST', 'cameras/0/calibration', { points: POINTS, frames: 1 }), 'cameras/0/calibration');
  },
  'a calibration without points, solving': async () => {
    await cameraRuns();
    await solves(() => ask('POST', 'cameras/0/calibration', { points: [], frames: 1 }), 'cameras/0/calibration');
  },
  'a joint calibration, collecting': async () => {
    await cameraRuns();
    await ask('POST', 'calibration', { seconds: 600 });
    await becomes(() => ask('GET', 'calibration'), ({ state, frames_taken: frames }) => state === 'collecting' && frames > 0);
  },
  'a joint calibration, solving': async () => {
    await cameraRuns();
    await solves(() => ask('POST', 'calibration', { seconds: 0, frames: 1 }), 'calibration');
  },
  'colours that are learnt, collecting': async () => {
    await cameraRuns();
    await ask('POST', 'cameras/0/colors/learning', { frames: 10 });
    await becomes(() => ask('GET', 'cameras/0/colors/learning'), ({ state }) => state === 'collecting');
  },
  'colours that are learnt, solving': async () => {
    await cameraRuns();
    await solves(() => ask('POST', 'cameras/0/colors/learning', { frames: 3 }), 'cameras/0/colors/learning');
  },
  'light that is followed': async () => {
    await service.patch({ op: 'replace', path: '/cameras/0/follow_light/enabled', value: true });
    await becomes(() => ask('GET', 'cameras/0/colors'), ({ light }) => light.state !== 'off');
  },
  'a clip that is written': async () => {
    await becomes(clips, ({ last_seconds: { cameras } }) => cameras.length === 2 && cameras.every(({ frames }) => frames > 1));
    await ask('POST', 'recordings/clips', { seconds: 1, seconds_after: 60, name: 'cut_short' });
    await becomes(clips, ({ clip: { state, frames } }) => state === 'writing' && frames > 0);
    return () => {
      const [name] = readdirSync(recordings).filter((file) => file.endsWith('.clip'));
      assert.ok(readClip(join(recordings, name)).is_finished, 'it ends with what there was');
    };
  },
  'a clip that is compared': async () => {
    linkSync(join(kept, 'long.clip'), join(recordings, 'long.clip'));
    const compare = () => ask('GET', 'recordings/compare');
    await isCaught(() => ask('POST', 'recordings/clips/long.clip/compare', { camera: 0, with: 'settings_now' }), compare,
      ({ state, done, frames }) => state === 'running' && done > 0 && done < frames, ({ state }) => state !== 'running');
  },
  'a clip that is downloaded by somebody slow': async () => {
    linkSync(join(kept, 'long.clip'), join(recordings, 'long.clip'));
    const socket = await said(httpHead('GET', 'api/recordings/clips/long.clip'));
    await once(socket, 'readable');
  },
  'an image that is uploaded by somebody slow': async () => {
    await said(`${httpHead('POST', 'api/images?folder=a&name=a.png', 1 << 20)}half`);
    await becomes(() => ask('GET', 'diagnostics'), ({ web: { connections } }) => connections > 1);
  },
  'an image that is uploaded and decoded': async () => {
    const image = readFileSync(join(kept, 'large.png'));
    leaveOpen(fetch(service.address('api/images?folder=a&name=a.png'), { method: 'POST', body: image }));
    await becomes(() => existsSync(join(service.stateFolder, 'images/.trial/image.png')), (there) => there);
  },
  'a match log that is recorded': async () => {
    await cameraRuns();
    await ask('POST', 'recordings/match-log', { record: true, name: 'cut_short' });
    await becomes(() => ask('GET', 'recordings'), ({ match_log: { state, messages } }) => state === 'recording' && messages.vision > 0);
    return () => {
      const [name] = readdirSync(recordings).filter((file) => file.endsWith('.log.gz'));
      execFileSync('gzip', ['--test', join(recordings, name)]);
      assert.ok(!existsSync(join(recordings, `${name}.unfinished`)), 'it is whole');
    };
  },
  'a match log that is read for its index': async () => {
    const file = join(recordings, 'long.log.gz');
    linkSync(join(kept, 'long.log.gz'), file);
    await hasOpen(file);
    return () => assert.ok(!existsSync(`${file}.index`), 'it was not read to its end');
  },
  'a moment of a match log that is looked for': async () => {
    const file = join(recordings, 'short.log.gz');
    linkSync(join(kept, 'short.log.gz'), file);
    await becomes(() => ask('GET', 'recordings'), ({ logs }) => logs.some(({ messages }) => messages !== null));
    for (let i = 0; i < 8; i++) leaveOpen(fetch(service.address('api/recordings/logs/short.log.gz/at?time_s=0')));
    await hasOpen(file);
  },
  'backups and support bundles that are made': async () => {
    await cameraRuns();
    const answers = [0, 1, 2, 3, 4, 5].flatMap(() => ['api/support', 'api/backup'].map((path) => fetch(service.address(path)).then((answer) => answer.arrayBuffer())));
    answers.forEach(leaveOpen);
    await Promise.race(answers);
  },
  'a source that is looked at and hangs': async () => {
    const source = silentSource(9);
    leaveOpen(fetch(service.address('api/sources/image'), { method: 'POST', body: JSON.stringify({ source }) }));
    return isWaitedFor(source);
  },
  'cameras that hang as they open': async () => {
    const sources = [0, 1].map(silentSource);
    await service.patch(...sources.map((value, i) => ({ op: 'replace', path: `/cameras/${i}/source`, value })));
    const ends = await Promise.all(sources.map(isWaitedFor));
    return () => ends.forEach((end) => end());
  },
  'a stage in a process of its own that hangs as it starts': async () => {
    await hasLibraries();
    leaveOpen(putStage('hangs_making'));
    await becomes(stageProcesses, (pids) => pids.length > 0);
  },
  'a stage in a process of its own that stands still': async () => {
    await hasLibraries();
    await becomes(async () => (await putStage('count_balls')).status, (status) => status === 200);
    await becomes(stageProcesses, (pids) => pids.length > 0);
    for (const pid of stageProcesses()) process.kill(pid, 'SIGSTOP');
  },
  'settings that are reloaded again and again': async () => {
    let goes = true;
    const hang = async () => {
      for (let i = 0; goes; i++) {
        service.settings.site = `Hall ${i}`;
        writeFileSync(join(service.folder, 'admin.json'), JSON.stringify(service.settings));
        process.kill(service.pid(), 'SIGHUP');
        await pause(20);
      }
    };
    const reloading = leaveOpen(hang());
    await becomes(() => service.log(), (log) => /settings file reloaded/.test(log));
    return async () => {
      goes = false;
      await reloading;
    };
  },
  'many who look, slow ones and silent ones among them': async () => {
    await cameraRuns();
    const viewers = await Promise.all([0, 1, 0, 1].map((camera) => openViewer(service.settings.panel.port, { camera, width: 780, fps: 30 })));
    await Promise.all([...Array(20)].map(async (_, i) => {
      const socket = await said(httpHead('GET', `api/cameras/${i % 2}/stream.mjpg`));
      socket.pause();
    }));
    await Promise.all([...Array(60)].map(() => said('GET /api/sta')));
    await becomes(() => viewers, (all) => all.every(({ pictures }) => pictures > 0), () => 'no pictures come');
    return () => viewers.forEach((viewer) => viewer.end());
  },
};
/** Restarts until all libraries are loaded: one that a busy computer did not load in time is skipped until the next
 * start. */
async function hasLibraries() {
  while ((await ask('GET', 'status')).alerts.some(({ id }) => id === 'stage_library')) {
    await service.stop();
    await service.start();
  }
}
/** Refused if the library does not answer in time. */
const putStage = (name) => fetch(service.address('api/settings'), {
  method: 'PATCH', body: JSON.stringify([{ op: 'replace', path: '/cameras/0/stack', value: ['segment', 'detect_robots', 'detect_balls', name, 'publish'] }]),
});
/** The processes in which stages run. */
function stageProcesses() {
  return readdirSync('/proc').filter((pid) => {
    try {
      const words = readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0');
      return words[1] === '--stage-process' && words[3] === 'run' && readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ')[1] === String(service.pid());
    } catch {
      return false; // it has ended
    }
  });
}

function report(during, times_ms) {
  const sorted = [...times_ms].sort((a, b) => a - b);
  const row = `| ${during} | ${times_ms.length} | ${sorted[Math.floor((sorted.length - 1) / 2)].toFixed(0)} | ${sorted.at(-1).toFixed(0)} |`;
  if (process.env.SSLV_STOP_TABLE) appendFileSync(process.env.SSLV_STOP_TABLE, `${row}\n`);
  console.log(row);
}

describe('SIGTERM during', () => {
  before(async () => {
    const stages = join(service.folder, 'stages');
    for (const folder of [kept, stages]) mkdirSync(folder, { recursive: true });
    for (const name of ['counting', 'hangs_making']) copyFileSync(join(LIBRARIES, name, `${name}.so`), join(stages, `${name}.so`));
    service.options = ['--stages-apart', stages];
    writeLongLog(join(kept, 'long.log.gz'), 100, 16);
    writeLongLog(join(kept, 'short.log.gz'), 1, 100);
    writeFileSync(join(kept, 'large.png'), largeImage());
    await service.start();
    await becomes(clips, ({ last_seconds: { cameras } }) => cameras.length === 2 && cameras.every(({ frames }) => frames > 1));
    await ask('POST', 'recordings/clips', { seconds: 1 });
    writeLongClip(join(recordings, (await newestClip()).name), join(kept, 'long.clip'));
    await service.stop();
  });
  after(() => service.end());

  for (const [during, begin] of Object.entries(activities)) {
    it(`${during}: it ends with exit code 0`, async () => {
      const times = [];
      for (let i = 0; i < TRIES; i++) {
        await service.stop();
        await service.forget();
        mkdirSync(recordings, { recursive: true });
        await service.start();
        const check = await begin();
        const began = performance.now();
        const patience = new AbortController();
        await Promise.race([service.stop(), pause(PATIENCE_MS, null, { ref: false, signal: patience.signal }).then(() => assert.fail(`it does not end:\n${service.log()}`))]);
        patience.abort();
        times.push(performance.now() - began);
        await check?.();
      }
      report(during, times);
    });
  }
});
