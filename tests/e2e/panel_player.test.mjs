// SPDX-License-Identifier: Apache-2.0
// The last seconds, clips and their player against the real service: kept by a button, played, stepped through, compared.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { beforeEach, describe, it } from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { accessibleInThemes, byId, createBrowser, DESKTOP, live, phone, PHONE, textBecomes, views } from './browser.mjs';
import { layoutFaults } from './layout.mjs';
import { gameController } from './league_messages.mjs';
import { becomes, createService, freeUdpPort } from './service.mjs';

const service = await createService('239.255.77.106');
const { address } = service;
const { aroundTests, screenshots, withPage } = createBrowser(service);
service.settings.recording = { match_logs: 'by_hand', last_seconds: { memory_mb: 256 } };

const ask = async (path, init) => (await fetch(address(`api/${path}`), init)).json();
const clips = () => ask('recordings/clips');
const clipPath = (name) => `recordings/clips/${encodeURIComponent(name)}`;
const row = (name) => `${byId('clip')}[data-name="${name}"]`;
const clipLink = (name) => `#/recordings/clips/${encodeURIComponent(name)}`;
/** So much of every camera is in memory. */
const inMemory = (seconds) => becomes(clips, ({ last_seconds: last }) => last.cameras.length > 0 && last.cameras.every((one) => one.seconds >= seconds));

/** A clip of the last seconds that is written and read: its name. */
async function makeClip(name, seconds = 3) {
  await inMemory(seconds);
  await becomes(clips, ({ clip }) => clip.state !== 'writing');
  const answer = await fetch(address('api/recordings/clips'), { method: 'POST', body: JSON.stringify({ seconds, name }) });
  assert.equal(answer.status, 202, await answer.text());
  const { clips: [first] } = await becomes(clips, ({ clip, clips: [newest] }) => clip.state === 'idle' && newest?.name.includes(name) && newest.begin_s !== null);
  return first.name;
}
async function clear() {
  await becomes(clips, ({ clip }) => clip.state !== 'writing');
  for (const { name } of (await clips()).clips) await ask(clipPath(name), { method: 'DELETE' });
}

/** A clip in which a team scores, as the game controller says. */
async function clipOfAGoal() {
  const group = '239.255.77.107', port = await freeUdpPort(), stage = { matchType: 1, stage: 1 };
  await service.patch(
    { op: 'replace', path: '/network/referee', value: { enabled: true, group, port, interface: 'lo' } },
    { op: 'replace', path: '/recording/last_seconds/memory_mb', value: 800 }, // for seconds at the cameras' full rate
  );
  await inMemory(1);
  const gc = createSocket('udp4').bind(0, '127.0.0.1');
  await once(gc, 'listening');
  gc.setMulticastInterface('127.0.0.1');
  const HALT = 0, STOP = 1, FORCE_START = 3;
  for (const [command, goals] of [[STOP, 0], [FORCE_START, 0], [FORCE_START, 1], [HALT, 1], [STOP, 1]]) {
    const said = gameController({ ...stage, yellow: ['TIGERs Mannheim', undefined, goals], blue: ['ER-Force', undefined, 0], command });
    for (let i = 0; i < 4; i++) {
      gc.send(said, port, group);
      await pause(250); // as a game controller repeats itself
    }
  }
  gc.close();
  return makeClip('goal', 4.5);
}

const picture = byId('played-picture');
const placeOf = async (page) => Number(await page.getAttribute(`${picture}[data-place]`, 'data-place'));
const placeBecomes = (page, place) => page.waitForSelector(`${picture}[data-place="${place}"]`);
const timeOf = async (page) => Number(await page.getAttribute(byId('play-time'), 'data-seconds'));
const openClip = async (page, name) => {
  await page.evaluate((to) => { location.hash = to; }, clipLink(name));
  await page.waitForSelector(`${picture}[data-place]`);
  return ask(`${clipPath(name)}/frames`);
};
/** How many pixels of the image are not of its most frequent colour: what is shown is an image. */
const colours = (page) => page.$eval(picture, (canvas) => {
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return new Set(Array.from({ length: 2000 }, (_, i) => { const at = 4 * Math.floor((i / 2000) * (data.length / 4)); return `${data[at] >> 4} ${data[at + 1] >> 4} ${data[at + 2] >> 4}`; })).size;
});

describe('the player', () => {
  aroundTests();
  beforeEach(async () => {
    await service.restore();
    await clear();
  });

  for (const { name: view, viewport, options, it: onView } of views) {
    const press = (page, selector) => (options.hasTouch ? page.tap(selector) : page.click(selector));
    const layoutIsSound = async (page) => assert.deepEqual(await layoutFaults(page, { isTouch: options.isMobile ?? false }), []);

    onView(`keeps the last seconds by a button, and the clip in a list (${view})`, withPage(viewport, '#/recordings', options, async (page) => {
      await inMemory(3);
      await page.waitForSelector(byId('no-clips'));
      await textBecomes(page, 'last-seconds-now', /^The last ([2-9]|\d{2,})(\.\d+)? (to [\d.]+ )?s of 2 cameras are in memory$/);
      // As much as there is, and no more than the settings say; both texts as they are at one moment.
      const [now, keep] = await page.evaluate((names) => names.map((name) => document.querySelector(name).textContent), [byId('last-seconds-now'), byId('keep')]);
      const most = Number(/([\d.]+) s of/.exec(now)[1]), said = Number(/Keep the last (\d+) s/.exec(keep)[1]);
      assert.ok(said >= 2 && said <= Math.min(10, most + 0.5), `${said} of ${most} s`);
      await accessibleInThemes(page, `no clips, ${view}`);
      await press(page, byId('keep'));
      await page.waitForSelector(byId('kept'));
      const { clips: [clip] } = await becomes(clips, ({ clips: [first] }) => first && first.begin_s !== null);
      await page.waitForSelector(`${row(clip.name)}:has-text("2 cameras")`);
      await layoutIsSound(page);
      const pin = `${row(clip.name)} ${byId('pin')}`;
      await press(page, pin);
      await page.waitForSelector(`${pin}[aria-pressed="true"]`);
      assert.equal((await clips()).clips[0].pinned, true);
      const file = await fetch(new URL(await page.getAttribute(`${row(clip.name)} ${byId('download')}`, 'href'), address('')));
      assert.equal((await file.arrayBuffer()).byteLength, clip.bytes);
      await press(page, `${row(clip.name)} ${byId('delete')}`);
      await page.waitForSelector(`${row(clip.name)} >> text=Delete this clip?`);
      await press(page, byId('delete-now'));
      await page.waitForSelector(byId('no-clips'));
      assert.deepEqual((await clips()).clips, []);
    }));

    onView(`plays, steps, jumps and goes back to live (${view})`, withPage(viewport, '#/recordings', options, async (page) => {
      const name = await makeClip('one');
      await press(page, `${row(name)} a >> nth=0`);
      await page.waitForSelector(`${picture}[data-place]`);
      const frames = await ask(`${clipPath(name)}/frames`);
      const [camera] = frames.cameras;
      await placeBecomes(page, camera.places[0]);
      assert.ok(await colours(page) > 5);
      // What is drawn is what the clip has of this very frame.
      const first = await ask(`${clipPath(name)}/frames/${camera.places[0]}`);
      assert.equal(await page.locator(byId('overlay-robot')).count(), first.robots.length);
      assert.equal(await page.locator(byId('overlay-ball')).count(), first.balls.length);
      assert.equal(Number(await page.getAttribute(picture, 'data-number')), first.number);
      await becomes(async () => Number(await page.getAttribute(byId('played-field'), 'data-robots')), (robots) => robots >= first.robots.length);

      await press(page, byId('step-on'));
      await placeBecomes(page, camera.places[1]);
      await press(page, byId('step-on'));
      await placeBecomes(page, camera.places[2]);
      await press(page, byId('step-back'));
      await placeBecomes(page, camera.places[1]);

      await page.selectOption(`${byId('speed')} select`, '4');
      await press(page, byId('play'));
      await page.waitForSelector(`${byId('play')}[data-playing="true"]`);
      await page.waitForSelector(`${byId('play')}[data-playing="false"]`); // at the end it stops
      await placeBecomes(page, camera.places.at(-1));
      await layoutIsSound(page);

      // Another camera, at the same moment.
      const other = frames.cameras[1];
      await press(page, `nav[aria-label="Cameras"] a[aria-label="Camera ${other.id}"]`);
      await becomes(() => placeOf(page), (place) => other.places.includes(place));

      // By the pointer to the middle.
      const { x, y, width } = await page.locator(byId('timeline')).boundingBox();
      if (options.hasTouch) await page.touchscreen.tap(x + width / 2, y + 8);
      else await page.mouse.click(x + width / 2, y + 8);
      await becomes(() => timeOf(page), (time) => Math.abs(time - frames.seconds / 2) < 0.1);

      await press(page, byId('back-to-live'));
      await page.waitForSelector(byId(`camera-picture-${other.id}`));
    }));

    onView(`goes back from a live page, and shows it from its beginning (${view})`, withPage(viewport, '#/camera/1', options, async (page) => {
      await inMemory(3);
      await textBecomes(page, 'go-back', /^Go back \d+ s/);
      await press(page, byId('go-back'));
      await page.waitForSelector(`${byId('clip-player')} ${picture}[data-place]`);
      const { clips: [clip] } = await clips();
      assert.match(clip.name, /look_back/);
      const frames = await ask(`${clipPath(clip.name)}/frames`);
      const camera = frames.cameras.find(({ id }) => id === 1);
      await placeBecomes(page, camera.places[0]);
      // Esc and its button lead to where one came from.
      await press(page, byId('back-to-live'));
      await page.waitForSelector(byId('camera-picture-1'));
    }));

    onView(`compares, and leads to what differs (${view})`, withPage(viewport, '#/recordings', options, async (page) => {
      const name = await makeClip('compared');
      const frames = await openClip(page, name);
      const count = frames.cameras[0].places.length;
      await press(page, byId('compare-recorded_settings'));
      await textBecomes(page, 'compare-result', new RegExp(`^Nothing differs in ${count} frames\\.$`));
      // Now the mask leaves next to nothing: all are lost.
      await service.patch({ op: 'replace', path: '/cameras/0/mask', value: { include: [{ points: [[0, 0], [2, 0], [2, 2]] }], exclude: [] } });
      await press(page, byId('compare-settings_now'));
      await textBecomes(page, 'compare-result', /^In \d+ of \d+ frames something differs: .*\d+ lost/);
      const { result } = await ask('recordings/compare');
      const { place, time_s: first } = result.differences.find(({ kind }) => kind === 'lost');
      await press(page, `${byId('difference')}[data-place="${place}"] >> nth=0`);
      await placeBecomes(page, place);
      assert.equal(await page.locator(`${byId('difference-ring')}[data-kind="lost"]`).count(), result.differences.filter((one) => one.place === place && one.kind === 'lost').length);
      // From there to the next, by a button; and back.
      await page.selectOption(`${byId('jump-to')} select`, 'difference');
      await press(page, byId('event-after'));
      const after = result.differences.find(({ time_s }) => time_s > first + 0.001);
      await placeBecomes(page, after.place);
      await textBecomes(page, 'timeline-tip', /Difference: /);
      await press(page, byId('event-before'));
      await placeBecomes(page, place);
      await layoutIsSound(page);
      await accessibleInThemes(page, `compared, ${view}`);
    }));
  }

  it('is used by the keyboard alone', withPage(DESKTOP, '#/recordings', {}, async (page) => {
    const name = await makeClip('keys');
    const frames = await openClip(page, name);
    const [{ places, id }] = frames.cameras;
    await placeBecomes(page, places[0]);
    await page.keyboard.press('ArrowRight');
    await placeBecomes(page, places[1]);
    await page.keyboard.press('ArrowLeft');
    await placeBecomes(page, places[0]);
    await page.keyboard.press('End');
    await placeBecomes(page, places.at(-1));
    await page.keyboard.press('Home');
    await placeBecomes(page, places[0]);
    await page.keyboard.press(' ');
    await page.waitForSelector(`${byId('play')}[data-playing="true"]`);
    await page.keyboard.press(' ');
    await page.waitForSelector(`${byId('play')}[data-playing="false"]`);
    // The same on the timeline, which has a value for those who listen.
    await page.focus(byId('timeline'));
    await page.keyboard.press('End');
    await placeBecomes(page, places.at(-1));
    // Which robots this camera lost is found by the page itself, and led to.
    const all = await Promise.all(places.map((place) => ask(`${clipPath(name)}/frames/${place}`)));
    const keys = ({ robots }) => robots.map((robot) => `${robot.team} ${robot.id}`);
    const lost = all.flatMap((frame, i) => (i > 0 && keys(all[i - 1]).some((key) => !keys(frame).includes(key)) ? [i] : []));
    if (lost.length) {
      await page.waitForSelector(`${byId('jump-to')} option[value="lost"]`, { state: 'attached' });
      await page.selectOption(`${byId('jump-to')} select`, 'lost');
      // Once all frames are known, the last one that was lost is what is before the end.
      await page.focus(byId('timeline'));
      await becomes(async () => {
        await page.keyboard.press('End');
        await page.keyboard.press('Shift+ArrowLeft');
        return timeOf(page);
      }, (time) => lost.at(-1) === places.length - 1 || Math.abs(time - frames.cameras[0].times_s[lost.at(-1)]) < 0.001);
      await page.keyboard.press('End');
      await placeBecomes(page, places.at(-1));
    }
    assert.match(await page.getAttribute(byId('timeline'), 'aria-valuetext'), /^00:\d\d\.\d\d of 00:\d\d\.\d\d/);
    await page.keyboard.press('Escape');
    await page.waitForSelector(byId(`camera-picture-${id}`));
    // And back again in time.
    await page.waitForSelector(`${byId('go-back')}:enabled`);
    await page.keyboard.press('b');
    await page.waitForSelector(`${byId('clip-player')} ${picture}[data-place]`);
  }));

  it('goes back from the live field, too', withPage(PHONE, '#/field/live', phone, async (page) => {
    await inMemory(3);
    await page.waitForSelector(`${byId('go-back')}:enabled`);
    await page.tap(byId('go-back'));
    await page.waitForSelector(`${byId('clip-player')} ${picture}[data-place]`);
    await page.tap(byId('back-to-live'));
    await page.waitForSelector(byId('live-field'));
  }));

  it('keeps its clock over a slow link, and has at most two requests on the way', withPage(DESKTOP, '#/recordings', {}, async (page) => {
    const name = await makeClip('slow');
    await page.clock.install();
    await page.reload();
    await live(page);
    const { seconds, cameras: [{ places }] } = await openClip(page, name);
    await placeBecomes(page, places[0]);
    await page.selectOption(`${byId('speed')} select`, '1');

    // Nothing comes while a second passes.
    const asked = new Set();
    const onTheWay = new Set(); // without those that the page has given up
    let most = 0;
    page.on('request', (request) => {
      const [, place] = /\/frames\/(\d+)(?:\/picture)?/.exec(request.url()) ?? [];
      if (!place) return;
      if (request.url().includes('/picture')) asked.add(place);
      most = Math.max(most, onTheWay.add(request).size);
    });
    for (const end of ['requestfinished', 'requestfailed']) page.on(end, (request) => onTheWay.delete(request));
    let goOn;
    const held = new Promise((resolve) => { goOn = resolve; });
    await page.route(/\/frames\/\d+/, async (route) => {
      await held;
      await route.continue().catch(() => {}); // the page no longer waits for it
    });
    await page.clock.pauseAt(await page.evaluate(() => Date.now() + 600_000)); // not so soon that it has passed by then
    await page.click(byId('play'));
    await page.waitForSelector(`${byId('play')}[data-playing="true"]`);
    await page.clock.runFor(1000);
    const time = await timeOf(page);
    assert.ok(Math.abs(time - 1) < 0.05, `at ${time} s after a second`);
    await becomes(() => onTheWay.size, (requests) => requests > 0);

    goOn();
    await page.clock.resume();
    await page.waitForSelector(`${byId('play')}[data-playing="false"]`);
    await placeBecomes(page, places.at(-1));
    assert.ok(Math.abs(await timeOf(page) - seconds) < 0.001);
    assert.ok(asked.size < places.length, `${asked.size} of ${places.length} images were asked for`);
    assert.ok(most <= 2, `${most} requests at once`);
  }));

  it('tries learnt colours on the last seconds before they are accepted', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
    await inMemory(3);
    await page.click(byId('learn'));
    await page.waitForSelector(`${byId('learning')}[data-learnt="true"]`);
    await page.click(byId('try-colours'));
    await page.waitForSelector(`${byId('clip-player')} ${picture}[data-place]`);
    await textBecomes(page, 'compare-result', /^(Nothing differs in|In \d+ of) \d+ frames/);
    const compared = await ask('recordings/compare');
    assert.match(compared.clip, /try_colours/);
    assert.equal(compared.with, 'learnt_colors');
    assert.equal(compared.camera, 0);
    await page.waitForSelector(`${byId('compare')} >> text=Nothing has changed yet`);
    // They still wait, and a reload of the player compares nothing again.
    assert.doesNotMatch(page.url(), /learnt/);
    await page.click(`${byId('compare')} a:has-text("Accept or reject them")`);
    await page.waitForSelector(`${byId('learning')}[data-learnt="true"]`);
    await page.click(byId('learn-reject'));
    await page.waitForSelector(byId('learning'), { state: 'detached' });
  }));

  it('says in one line that its clip is gone', withPage(DESKTOP, '#/recordings', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser writes each 404 down
    const name = await makeClip('gone');
    await openClip(page, name);
    await page.route(/\/frames\/\d+/, (route) => route.fulfill({ status: 404, json: { error: 'there is no such recording' } }));
    await ask(clipPath(name), { method: 'DELETE' });
    await page.keyboard.press('End');
    await page.waitForSelector(byId('clip-gone'));
    await page.click(`${byId('clip-gone')} a`);
    await page.waitForSelector(byId('no-clips'));
  }));

  it('plays a log, with what the referee said', withPage(DESKTOP, '#/recordings', {}, async (page) => {
    const record = (body) => ask('recordings/match-log', { method: 'POST', body: JSON.stringify(body) });
    await record({ record: true, name: 'played' });
    await becomes(() => ask('recordings'), ({ match_log: now }) => now.messages.vision > 20 && now.seconds > 2);
    await record({ record: false });
    const { logs: [log] } = await becomes(() => ask('recordings'), ({ logs: [first] }) => first?.messages && first.seconds !== null);
    try {
      await page.evaluate((to) => { location.hash = to; }, `#/recordings/logs/${encodeURIComponent(log.name)}`);
      await page.waitForSelector(byId('log-player'));
      await page.click('button:has-text("Raw")');
      await page.keyboard.press('End');
      await page.keyboard.press('Home');
      for (let i = 0; i < 12; i++) await page.keyboard.press('ArrowRight');
      await becomes(() => timeOf(page), (time) => Math.abs(time - 0.48) < 0.001);
      await becomes(async () => Number(await page.getAttribute(byId('played-field'), 'data-robots')), (robots) => robots > 0);
      await textBecomes(page, 'log-referee', /No game controller was heard at this moment/);
      assert.deepEqual(await layoutFaults(page), []);
      await accessibleInThemes(page, 'a log that is played');
    } finally {
      await ask(`recordings/logs/${encodeURIComponent(log.name)}`, { method: 'DELETE' });
    }
  }));

  screenshots([{
    file: 'player-dark.jpg', theme: 'dark', path: '#/recordings', viewport: DESKTOP, options: {},
    ready: async (page) => {
      const name = await clipOfAGoal();
      const { cameras: [first] } = await openClip(page, name);
      await becomes(() => page.locator(byId('timeline')).count(), (count) => count === 1);
      const place = first.places[Math.floor(first.places.length / 2)];
      await page.keyboard.press('Home');
      for (let i = 0; i < Math.floor(first.places.length / 2); i++) await page.keyboard.press('ArrowRight');
      await placeBecomes(page, place);
    },
  }]);
});
