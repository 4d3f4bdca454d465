// SPDX-License-Identifier: Apache-2.0
// Does GO mean that the field can play? Many kinds of faults are injected into the real service, which must report each
// fault within seconds, link to a page that fixes it, and return to GO when it is gone.
//   SSLV_VERDICT_TABLE  a file: tests every fault at each strength and appends a row of Markdown for each
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { appendFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { detectionOf, gameController, geometryOf } from './league_messages.mjs';
import { becomes, createService, freeUdpPort, OF_THE_COMPUTER, root } from './service.mjs';

const TABLE = process.env.SSLV_VERDICT_TABLE;
const service = await createService('239.255.77.97');
const GC_GROUP = '239.255.77.98';
const gcPort = await freeUdpPort();
service.settings.network.referee = { enabled: true, group: GC_GROUP, port: gcPort, interface: 'lo' };
// Enough robots that some are always in the overlap of both cameras.
const ROBOTS = 11;
for (const { source: to } of service.settings.cameras) Object.assign(to, { robots_yellow: ROBOTS, robots_blue: ROBOTS });

const replace = (path, value) => ({ op: 'replace', path, value });
const CAMERAS = [0, 1];
const { classes } = service.settings.cameras[0].colors;
const stack = ['segment', 'detect_robots', 'detect_balls', 'publish'];
const without = (...labels) => [replace('/cameras/0/colors/classes', classes.filter(({ label }) => !labels.includes(label)))];
/** Changes the colours of some labels, for all cameras. */
const recolored = (change) => CAMERAS.map((i) => replace(`/cameras/${i}/colors/classes`, classes.map((one) => ({ ...one, ...change(one) }))));
const swapped = (a, b) => recolored(({ label }) => ({ label: label === a ? b : label === b ? a : label }));
/** Hides a camera's image from its left edge to this share of its width. */
const hidden = (share, i = 0) => [{ op: 'add', path: `/cameras/${i}/mask/exclude/-`, value: { points: [[-1, -1], [780 * share, -1], [780 * share, 581], [-1, 581]] } }];
const source = (i, key, value) => replace(`/cameras/${i}/source/${key}`, value);
const forAll = (key, value) => CAMERAS.map((i) => source(i, key, value));
const calibrated = (i, change) => {
  const now = service.settings.cameras[i].calibration;
  return Object.entries(change(now)).map(([key, value]) => replace(`/cameras/${i}/calibration/${key}`, value));
};
/** The camera's pose with the world rotated about an axis of the field: "z" is up. */
function turned(now, axis, degrees) {
  const [x, y, z, w] = [now.q0, now.q1, now.q2, now.q3];
  const s = Math.sin((degrees * Math.PI) / 360);
  const c = Math.cos((degrees * Math.PI) / 360);
  const [a, b, d] = ['x', 'y', 'z'].map((one) => (one === axis ? s : 0));
  return { q0: w * a + x * c + y * d - z * b, q1: w * b - x * d + y * c + z * a, q2: w * d + x * b - y * a + z * c, q3: w * c - x * a - y * b - z * d };
}
const lost = join(root, 'tests', 'the/camera/is/away.jpg');
const DIVISION_A = { field_length: 12000, field_width: 9000, goal_width: 1800, boundary_width_goal_line: 600, penalty_area_depth: 1800, penalty_area_width: 3600, goal_center_to_penalty_mark: 8000 };
const sizes = (change) => Object.entries(change).map(([key, value]) => replace(`/field/${key}`, value));

// Packets sent while a fault lasts.
const GC = { yellow: ['', ROBOTS], blue: ['', ROBOTS] };
const toVision = (...packets) => ({ group: service.settings.network.vision.group, port: service.settings.network.vision.port, packets });
const toReferee = (...packets) => ({ group: GC_GROUP, port: gcPort, packets });
const detecting = (...cameras) => toVision(...cameras.map(detectionOf));

// Each fault: the check that must report it, alert ids of which one must name it, and the changes that cause it, at
// three strengths from weak to strong. `fails`: the strength from which the field cannot play; 3: it only warns.
// `sent`: packets to send during the fault, for each strength. `always`: tested in every run, at its last strength.
const one = [[0], [1], [0, 1]];
const faults = [
  { name: 'a camera in the dark', always: true, check: 'robots', alerts: ['robots_lost'], fails: 0, strengths: [0.12, 0.08, 0.05].map((light) => [source(0, 'light', light)]) },
  { name: 'all cameras in the dark', check: 'robots', alerts: ['robots_lost'], fails: 0, strengths: [0.12, 0.08, 0.05].map((light) => forAll('light', light)) },
  { name: 'far too much light', check: 'robots', alerts: ['robots_lost', 'ball_lost'], fails: 3, strengths: [2.2, 2.6, 3].map((light) => forAll('light', light)) },
  { name: 'a colour erased', always: true, check: 'colors', alerts: ['colors_missing'], fails: 0, strengths: [without('orange'), without('yellow', 'blue'), without('orange', 'yellow', 'blue', 'pink', 'green')] },
  { name: 'no pink or no green', check: 'colors', alerts: ['colors_missing'], fails: 0, strengths: [without('pink'), without('green'), without('pink', 'green')] },
  { name: 'two colours swapped', always: true, check: ['colors', 'robots'], alerts: ['colors_swapped', 'robots_lost'], fails: 0, strengths: [swapped('yellow', 'green'), swapped('blue', 'pink'), swapped('pink', 'green')] },
  { name: 'colours of another lamp', check: 'robots', alerts: ['robots_lost', 'ball_lost'], fails: 0, strengths: [-25, -35, -40].map((by) => recolored(({ hue_deg: [low, high] }) => ({ hue_deg: [low + by, high + by] }))) },
  { name: 'colours that want more light', check: 'robots', alerts: ['robots_lost'], fails: 0, strengths: [200, 225, 250].map((luma) => recolored(({ luma: [, high] }) => ({ luma: [luma, high] }))) },
  { name: 'orange that is yellow', check: 'robots', alerts: ['ball_lost'], fails: 3, strengths: [[148, 150], [160, 170], [200, 210]].map((hue) => recolored(({ label, hue_deg }) => ({ hue_deg: label === 'orange' ? hue : hue_deg }))) },
  { name: 'a mask over the field', always: true, check: 'coverage', alerts: ['field_uncovered', 'mask_hides_all'], fails: 1, strengths: [0.25, 0.6, 1.1].map((share) => hidden(share)) },
  { name: 'a mask over all images', check: 'coverage', alerts: ['mask_hides_all'], fails: 0, strengths: one.map((all) => all.flatMap((i) => hidden(1.1, i))) },
  { name: 'a calibration that is off', always: true, check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [35, 80, 150].map((mm) => calibrated(0, ({ tx }) => ({ tx: tx + mm }))) },
  { name: 'a camera that was turned', check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [0.7, 2, 5].map((by) => calibrated(1, (now) => turned(now, 'z', by))) },
  { name: 'a camera that was tilted', check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [0.7, 1.5, 4].map((by) => calibrated(0, (now) => turned(now, 'x', by))) },
  { name: 'a camera that hangs lower', check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [80, 250, 500].map((mm) => calibrated(0, ({ tz }) => ({ tz: tz + mm }))) },
  { name: 'another lens', check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [1.02, 1.06, 1.2].map((by) => calibrated(0, ({ focal_length: f }) => ({ focal_length: f * by }))) },
  { name: 'distortion that is not there', check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [0.1, 0.14, 0.3].map((distortion) => calibrated(0, () => ({ distortion }))) },
  { name: 'a field turned by half', check: ['coverage', 'agreement'], alerts: ['field_uncovered', 'lines_missing', 'lines_off'], fails: 0, strengths: [[0, 180], [1, 180], [0, 90]].map(([i, by]) => calibrated(i, (now) => turned(now, 'z', by))) },
  { name: 'the calibration of another camera', check: 'agreement', alerts: ['lines_missing', 'lines_off'], fails: 0, strengths: [[[1, 0]], [[0, 1]], [[0, 1], [1, 0]]].map((all) => all.flatMap(([to, from]) => calibrated(to, () => service.settings.cameras[from].calibration))) },
  { name: 'no calibration', always: true, check: 'calibration', alerts: ['not_calibrated'], fails: 0, strengths: one.map((all) => all.map((i) => replace(`/cameras/${i}/calibration`, null))) },
  { name: 'a calibration of another size', check: 'calibration', alerts: ['calibration_other_size'], fails: 3, strengths: [[640, 480], [1280, 960], [2448, 2048]].map(([w, h]) => calibrated(0, () => ({ pixel_image_width: w, pixel_image_height: h }))) },
  { name: 'the other division’s field', always: true, check: 'agreement', alerts: ['field_size', 'lines_missing', 'lines_off'], fails: 0, strengths: [DIVISION_A, { ...DIVISION_A, penalty_area_depth: 1000, penalty_area_width: 2000 }, { field_length: 12000, field_width: 9000 }].map(sizes) },
  { name: 'penalty areas of other years', check: 'agreement', alerts: ['lines_off', 'lines_missing'], fails: 1, strengths: [{ penalty_area_depth: 1040 }, { penalty_area_depth: 1100, penalty_area_width: 2150 }, { penalty_area_depth: 1200, penalty_area_width: 2400 }].map(sizes) },
  { name: 'a field a little larger or smaller', check: 'agreement', alerts: ['lines_off', 'lines_missing'], fails: 1, strengths: [{ field_length: 9080 }, { field_length: 8800 }, { field_width: 6300, field_length: 9300 }].map(sizes) },
  { name: 'a stack that sends nothing', always: true, check: 'network', alerts: ['not_published'], fails: 0, strengths: one.map((all) => all.map((i) => replace(`/cameras/${i}/stack`, stack.slice(0, 3)))) },
  { name: 'a camera that looks at black and white', always: true, check: 'colors', alerts: ['images_grey'], fails: 0, strengths: one.map((all) => all.map((i) => source(i, 'pixel_format', 'mono8'))) },
  { name: 'robots that vanish', always: true, check: 'robots', alerts: ['robots_lost'], fails: 1, strengths: [ROBOTS - 1, ROBOTS - 3, 0].map((count) => CAMERAS.flatMap((i) => ['yellow', ...(count ? [] : ['blue'])].map((color) => source(i, `robots_${color}`, count)))) },
  { name: 'robots that nobody can read', check: 'robots', alerts: ['robots_lost'], fails: 1, strengths: [1, 4, 12].map((count) => forAll('covered_dots', count)) },
  { name: 'no ball', check: 'robots', alerts: ['ball_lost'], fails: 3, strengths: [forAll('balls', 0), [...forAll('balls', 0), ...forAll('distractors', 10)], [...forAll('balls', 0), ...forAll('distractors', 20)]] },
  { name: 'one id in two places', always: true, check: 'robots', alerts: ['robot_twice'], fails: 0, strengths: [2, 3, 4].map((seed) => [source(1, 'seed', seed)]) },
  { name: 'two robots with one pattern', always: true, check: 'robots', alerts: ['robot_twice'], fails: 0, strengths: [1, 2, 3].map((count) => forAll('twins', count)) },
  { name: 'a roster that is not there', check: 'robots', alerts: ['robots_missing'], fails: 3, strengths: [[0, 11], [0, 11, 12], [13, 14, 15]].map((ids) => [replace('/teams/yellow/ids', ids)]) },
  { name: 'more robots than may play', check: 'robots', alerts: ['robots_many'], fails: 3, sent: [10, 9, 0].map((count) => toReferee(gameController({ ...GC, blue: ['', count] }))) },
  { name: 'a robot height that is not true', check: 'agreement', alerts: ['cameras_disagree'], fails: 2, strengths: [70, 240, 20].map((mm) => ['yellow', 'blue'].map((color) => replace(`/teams/${color}/robot_height`, mm))) },
  { name: 'a camera that is lost', always: true, check: 'cameras', alerts: ['camera_lost'], fails: 0, strengths: one.map((all) => all.map((i) => replace(`/cameras/${i}/source`, { backend: 'files', path: lost }))) },
  { name: 'a camera that was taken out of the settings', check: 'coverage', alerts: ['field_uncovered'], fails: 0, strengths: [1, 0, 1].map((i) => [{ op: 'remove', path: `/cameras/${i}` }]) },
  { name: 'an image of another size than the calibration', check: 'cameras', alerts: ['camera_lost'], fails: 0, strengths: [[640, 480], [800, 600], [1280, 1024]].map(([width, height]) => [source(0, 'width', width), source(0, 'height', height)]) },
  { name: 'more images than this computer can take', check: ['pictures', 'cameras', 'latency'], alerts: ['frames_dropped', 'latency_high', 'stage_slow', 'camera_slow'], fails: 3, strengths: [500, 700, 1000].map((rate) => forAll('frame_rate_hz', rate)) },
  { name: 'a network card that is not there', always: true, check: 'network', alerts: ['not_sending'], fails: 0, strengths: ['nocard0', '10.9.8.7', 'wlan9'].map((card) => [replace('/network/vision/interface', card)]) },
  { name: 'another vision with our cameras’ numbers', check: 'other_visions', alerts: ['vision_same_camera'], fails: 0, sent: [[0], [1], [0, 1]].map((all) => detecting(...all)) },
  { name: 'another vision with another field', check: 'other_visions', alerts: ['vision_other_field'], fails: 3, sent: [[12000, 9000], [9000, 6500], [6050, 4050]].map(([length, width]) => toVision(detectionOf(6), geometryOf(length, width))) },
  { name: 'two game controllers', check: 'referee', alerts: ['two_game_controllers'], fails: 3, sent: ['b', 'another', 'the other field’s'].map((other) => toReferee(gameController(GC), gameController({ ...GC, source: other }))) },
  { name: 'a team whose height is not known', check: 'teams', alerts: ['team_unknown'], fails: 3, sent: ['A', 'Nobody', 'Nobody knows us'].map((text) => toReferee(gameController({ ...GC, yellow: [text, ROBOTS] }))) },
];

/** Names of the panel's pages, from its router: where an alert may link to. */
const PAGES = [...readFileSync(join(root, 'webui/src/router.ts'), 'utf8').matchAll(/\{ name: '(\w+)', title/g)].map(([, name]) => name);

const status = async () => (await fetch(service.address('api/status'))).json();
const states = ({ checks }) => Object.fromEntries(checks.map(({ id, state, text }) => [id, `${state}: ${text}`]));
const tell = (now) => JSON.stringify({ go: now.go, checks: states(now), alerts: now.alerts.map(({ title }) => title) });
// Packets go to this computer only, which may be busy with other tests.
const MAY_WARN = new Set(['network', 'referee', 'clock', ...OF_THE_COMPUTER.checks]);
const isGood = ({ checks, alerts, cameras }) => {
  const slow = alerts.filter(({ id }) => OF_THE_COMPUTER.alerts.includes(id)).map(({ title }) => title);
  return cameras.every(({ state }) => state === 'running') &&
    checks.every(({ id, state, text }) => state === 'pass' || state === 'unknown' || MAY_WARN.has(id) || slow.includes(text.replace(/ \(and \d+ more\)$/, '')));
};
const robotsOf = ({ checks }) => checks.find(({ id }) => id === 'robots').value;
let robots; // in view when all is well
/** Waits until all is well and as many robots are seen as at first, so that a later loss is noticed. */
const becomesGood = () => becomes(status, (now) => isGood(now) && (robots === undefined || robotsOf(now) === robots), tell);

let socket;
// Checked only by ./run verdict: elsewhere other tests may load the computer.
const NAMED_WITHIN_S = 5;
const times_s = [];
let extra = null; // {group, port, packets}: sent in addition
/** Repeatedly sends the game controller's message and the packets of the current fault. */
const sendAll = () => {
  const isController = extra?.port === gcPort;
  for (const { group, port, packets } of [...(isController ? [] : [toReferee(gameController(GC))]), ...(extra ? [extra] : [])]) {
    for (const packet of packets) socket.send(packet, port, group);
  }
};

describe('the verdict', () => {
  let settings;
  let timer;
  before(async () => {
    socket = createSocket('udp4').bind(0, '127.0.0.1');
    await once(socket, 'listening');
    socket.setMulticastInterface('127.0.0.1');
    timer = setInterval(sendAll, 50);
    await service.start();
    // All robots are in view of the cameras; after eight seconds or more each has been seen steadily.
    robots = robotsOf(await becomes(status, (now) => isGood(now) && now.cameras.every(({ frames, fps }) => frames > 80 && fps > 1), tell));
    ({ settings } = await (await fetch(service.address('api/settings'))).json());
  });
  after(async () => {
    clearInterval(timer);
    socket.close();
    await service.end();
    if (!TABLE) return;
    const late = times_s.filter((one) => one > NAMED_WITHIN_S).length;
    appendFileSync(TABLE, `\n${times_s.length} faults named, ${late} of them after more than ${NAMED_WITHIN_S} s\n`);
    assert.equal(late, 0, `named after more than ${NAMED_WITHIN_S} s`);
  });

  for (const { name, check, alerts, fails, always, strengths = [[], [], []], sent = [] } of faults) {
    if (!always && !TABLE) continue;
    it(`names ${name}`, async () => {
      const checks = [check].flat();
      for (const [strength, change] of strengths.entries()) {
        if (!TABLE && strength !== strengths.length - 1) continue;
        await becomesGood();
        const began = performance.now();
        if (change.length > 0) await service.patch(...change);
        extra = sent[strength] ?? null;
        try {
          const isNamed = (now) => now.alerts.some(({ id }) => alerts.includes(id)) &&
            now.checks.some(({ id, state }) => checks.includes(id) && (strength >= fails ? state === 'fail' : state === 'warn' || state === 'fail')) &&
            (strength < fails || !now.go);
          const now = await becomes(status, isNamed, tell);
          const took_s = (performance.now() - began) / 1000;
          for (const { id, page, fix } of now.alerts) {
            assert.ok(fix.length > 10, `${id} says what to do`);
            if (page) assert.ok(['', ...PAGES].includes(page.replace(/^#\/?/, '').split('/')[0]), `${id} leads to ${page}, which is no page`);
          }
          const alert = now.alerts.find(({ id }) => alerts.includes(id));
          times_s.push(took_s);
          if (TABLE) appendFileSync(TABLE, `| ${name} | ${strength + 1} | ${now.go ? 'warning' : 'NO-GO'} | ${alert.title} | ${took_s.toFixed(1)} |\n`);
        } finally {
          extra = null;
          if (change.length > 0) await service.patch(replace('', settings));
        }
      }
      await becomesGood();
    });
  }

  it('does not pass a field whose robots and ball were never seen', async () => {
    await service.stop();
    for (const { source: to } of service.settings.cameras) Object.assign(to, { robots_yellow: 0, robots_blue: 0, balls: 0 });
    await service.start();
    const robotsCheck = (now) => now.checks.find(({ id }) => id === 'robots');
    await becomes(status, (now) => now.cameras.every(({ frames }) => frames > 10) && robotsCheck(now).state === 'warn' && /nothing is seen/.test(robotsCheck(now).text), tell);
    extra = toReferee(gameController({ ...GC, stage: 1, command: 2 }));
    const missed = await becomes(status, (now) => now.alerts.some(({ id, severity }) => id === 'robots_none' && severity === 'bad'), tell);
    assert.equal(missed.go, false);
    extra = null;
    await becomes(status, (now) => !now.alerts.some(({ id }) => id === 'robots_none'), tell);
    for (const { source: to } of service.settings.cameras) Object.assign(to, { robots_yellow: ROBOTS, robots_blue: ROBOTS });
    await service.stop();
    await service.start();
    await becomes(status, (now) => robotsCheck(now).state === 'warn' && /no ball is seen/.test(robotsCheck(now).text), tell);
  });
});
