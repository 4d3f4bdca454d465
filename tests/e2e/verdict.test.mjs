// SPDX-License-Identifier: Apache-2.0
// Whether GO means that the field can play: faults of many kinds are put into the real service, which must name each
// within seconds, offer a page that mends it, and be content again when it is gone.
//   SSLV_VERDICT_TABLE  a file: every fault at each strength, and a row of Markdown for each
import assert from 'node:assert/strict';
import { appendFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { becomes, createService, root } from './service.mjs';

const TABLE = process.env.SSLV_VERDICT_TABLE;
const service = await createService('239.255.77.97');

const replace = (path, value) => ({ op: 'replace', path, value });
const calibration = service.settings.cameras[0].calibration;
const classes = service.settings.cameras[0].colors.classes;
const stack = ['segment', 'detect_robots', 'detect_balls', 'publish'];
const without = (...labels) => [replace('/cameras/0/colors/classes', classes.filter(({ label }) => !labels.includes(label)))];
/** Hides the image of camera 0 from its left edge to this share of its width. */
const hidden = (share) => [{ op: 'add', path: '/cameras/0/mask/exclude/-', value: { points: [[-1, -1], [780 * share, -1], [780 * share, 581], [-1, 581]] } }];
const lost = 'the/camera/is/away.jpg';

// Each fault: the check that must say so, ids of alerts of which one must name it, and the changes that make it, three
// strengths of it from weak to strong. `fails`: from which strength on the field cannot play.
const faults = [
  { name: 'a camera in the dark', check: 'robots', alerts: ['robots_lost'], fails: 0, strengths: [0.12, 0.08, 0.05].map((light) => [replace('/cameras/0/source/light', light)]) },
  { name: 'all cameras in the dark', check: 'robots', alerts: ['robots_lost'], fails: 0, strengths: [0.12, 0.08, 0.05].map((light) => [0, 1].map((i) => replace(`/cameras/${i}/source/light`, light))) },
  { name: 'a colour erased', check: 'colors', alerts: ['colors_missing'], fails: 0, strengths: [without('orange'), without('yellow', 'blue'), without('orange', 'yellow', 'blue', 'pink', 'green')] },
  { name: 'a mask over the field', check: 'coverage', alerts: ['field_uncovered', 'mask_hides_all'], fails: 1, strengths: [0.25, 0.6, 1.1].map(hidden) },
  { name: 'a calibration that is off', check: 'agreement', alerts: ['lines_off', 'lines_missing', 'cameras_disagree'], fails: 1, strengths: [35, 80, 150].map((mm) => [replace('/cameras/0/calibration/tx', calibration.tx + mm)]) },
  { name: 'no calibration', check: 'calibration', alerts: ['not_calibrated'], fails: 0, strengths: [[replace('/cameras/0/calibration', null)], [replace('/cameras/1/calibration', null)], [0, 1].map((i) => replace(`/cameras/${i}/calibration`, null))] },
  { name: 'a stack that sends nothing', check: 'network', alerts: ['not_published'], fails: 0, strengths: [[0], [1], [0, 1]].map((all) => all.map((i) => replace(`/cameras/${i}/stack`, stack.slice(0, 3)))) },
  { name: 'a camera that looks at black and white', check: 'robots', alerts: ['robots_lost'], fails: 0, strengths: [[0], [1], [0, 1]].map((all) => all.map((i) => replace(`/cameras/${i}/source/pixel_format`, 'mono8'))) },
  { name: 'robots that vanish', check: 'robots', alerts: ['robots_lost'], fails: 1, strengths: [5, 3, 0].map((count) => [0, 1].flatMap((i) => ['yellow', ...(count ? [] : ['blue'])].map((team) => replace(`/cameras/${i}/source/robots_${team}`, count)))) },
  { name: 'one id in two places', check: 'robots', alerts: ['robot_twice'], fails: 0, strengths: [2, 3, 4].map((seed) => [replace('/cameras/1/source/seed', seed)]) },
  { name: 'a roster that is not there', check: 'robots', alerts: ['robots_missing'], fails: 3, strengths: [[0, 6], [0, 9, 10], [11, 12, 13]].map((ids) => [replace('/teams/yellow/ids', ids)]) },
  { name: 'a camera that is lost', check: 'cameras', alerts: ['camera_lost'], fails: 0, strengths: [[0], [1], [0, 1]].map((all) => all.map((i) => replace(`/cameras/${i}/source`, { backend: 'files', path: join(root, 'tests', lost) }))) },
  { name: 'an image of another size than the calibration', check: 'cameras', alerts: ['camera_lost'], fails: 0, strengths: [[640, 480], [800, 600], [1280, 1024]].map(([width, height]) => [replace('/cameras/0/source/width', width), replace('/cameras/0/source/height', height)]) },
];

/** What the panel's own tests call pages: where an alert may lead. */
const PAGES = [...readFileSync(join(root, 'webui/src/router.ts'), 'utf8').matchAll(/\{ name: '(\w+)', title/g)].map(([, name]) => name);

const status = async () => (await fetch(service.address('api/status'))).json();
const states = ({ checks }) => Object.fromEntries(checks.map(({ id, state, text }) => [id, `${state}: ${text}`]));
const tell = (now) => JSON.stringify({ go: now.go, checks: states(now), alerts: now.alerts.map(({ title }) => title) });
// Here nobody referees, and packets go to this computer only.
const MAY_WARN = new Set(['network', 'referee', 'computer', 'clock', 'pictures', 'latency']);
const isGood = ({ go, checks }) => go && checks.every(({ id, state }) => state === 'pass' || MAY_WARN.has(id));
const robotsOf = ({ checks }) => checks.find(({ id }) => id === 'robots').value;
let robots; // in view when all is well
/** As many robots are seen as at first: what is lost from here on is missed. */
const becomesGood = () => becomes(status, (now) => isGood(now) && (robots === undefined || robotsOf(now) === robots), tell);

describe('the verdict', () => {
  let settings;
  before(async () => {
    await service.start();
    // The robots stand or drive where cameras see them; by then each was seen steadily.
    await becomes(status, (now) => isGood(now) && now.uptime_s > 8, tell);
    robots = robotsOf(await status());
    ({ settings } = await (await fetch(service.address('api/settings'))).json());
  });
  after(() => service.end());

  for (const { name, check, alerts, fails, strengths } of faults) {
    it(`names ${name}`, async () => {
      for (const [strength, change] of strengths.entries()) {
        if (!TABLE && strength !== 2) continue;
        await becomesGood();
        const began = performance.now();
        await service.patch(...change);
        const isNamed = (now) => now.alerts.some(({ id }) => alerts.includes(id)) &&
          now.checks.find(({ id }) => id === check).state === (strength >= fails ? 'fail' : 'warn') && now.go === strength < fails;
        const now = await becomes(status, isNamed, tell);
        const took_s = (performance.now() - began) / 1000;
        for (const { id, page, fix } of now.alerts) {
          assert.ok(fix.length > 10, `${id} says what to do`);
          if (page) assert.ok(['', ...PAGES].includes(page.replace(/^#\/?/, '').split('/')[0]), `${id} leads to ${page}, which is no page`);
        }
        const alert = now.alerts.find(({ id }) => alerts.includes(id));
        if (TABLE) appendFileSync(TABLE, `| ${name} | ${strength + 1} | ${now.go ? 'warning' : 'NO-GO'} | ${alert.title} | ${took_s.toFixed(1)} |\n`);
        await service.patch(replace('', settings));
      }
      await becomesGood();
    });
  }
});
