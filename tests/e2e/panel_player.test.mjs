// SPDX-License-Identifier: Apache-2.0
// The image ring, clips and the player with the real service: a clip is kept by a button, played, stepped through and
// compared.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { beforeEach, describe, it } from 'node:test';
import { accessibleInThemes, byId, createBrowser, DESKTOP, live, phone, PHONE, textBecomes, views } from './browser.mjs';
import { layoutFaults } from './layout.mjs';
import { becomes, createService } from './service.mjs';

const service = await createService('239.255.77.106');
const { address } = service;
const { aroundTests, withPage } = createBrowser(service);
service.settings.recording = { match_logs: 'by_hand', last_seconds: { memory_mb: 256 } };

const ask = async (path, init) => (await fetch(address(`api/${path}`), init)).json();
const clips = () => ask('recordings/clips');
const clipPath = (name) => `recordings/clips/${encodeURIComponent(name)}`;
const row = (name) => `${byId('clip')}[data-name="${name}"]`;
const clipLink = (name) => `#/recordings/clips/${encodeURIComponent(name)}`;
/** Waits until each camera has so many seconds in memory. */
const inMemory = (seconds) => becomes(clips, ({ last_seconds: last }) => last.cameras.length > 0 && last.cameras.every((one) => one.seconds >= seconds));

/** Makes a clip of the last seconds; returns its name once the service has indexed it. */
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

const picture = byId('played-picture');
const placeOf = async (page) => Number(await page.getAttribute(`${picture}[data-place]`, 'data-place'));
const placeBecomes = (page, place) => page.waitForSelector(`${picture}[data-place="${place}"]`);
const timeOf = async (page) => Number(await page.getAttribute(byId('play-time'), 'data-seconds'));
const openClip = async (page, name) => {
  await page.evaluate((to) => { location.hash = to; }, clipLink(name));
  await page.waitForSelector(`${picture}[data-place]`);
  return ask(`${clipPath(name)}/frames`);
};
/** Number of distinct colours (4 bits per channel) among 2000 pixels of the image, to tell it from an empty canvas. */
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
      // The page offers all seconds in memory, up to the setting's limit; both texts are read at the same moment.
      const [now, keep] = await page.evaluate((names) => names.map((name) => document.querySelector(name).textContent), [byId('last-seconds-now'), byId('keep')]);
      const most = Number(/([\d.]+) s of/.exec(now)[1]), said = Number(/Keep the last (\d+) s/.exec(keep)[1]);
      assert.ok(said >= 2 && said <= Math.min(10, most + 0.5), `${said} of ${most} s`);
      await accessibleInThemes(page, `no clips, ${view}`);
      await page.fill(byId('clip-name'), 'a/b');
      await page.waitForSelector(`${byId('keep')}:disabled`);
      await page.fill(byId('clip-name'), 'Late goal');
      await press(page, byId('keep'));
      await page.waitForSelector(byId('kept'));
      const { clips: [clip] } = await becomes(clips, ({ clips: [first] }) => first && first.begin_s !== null);
      await page.waitForSelector(`${row(clip.name)}:has-text("2 cameras")`);
      await page.waitForSelector(`${row(clip.name)}:has-text("Late goal")`);
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
      // The overlay shows the clip's data of this frame.
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
      await placeBecomes(page, camera.places.at(-1));
      await page.waitForSelector(`${byId('play')}[data-playing="false"]`); // stops at the end
      await layoutIsSound(page);

      // Switch to another camera at the same time.
      const other = frames.cameras[1];
      await press(page, `nav[aria-label="Cameras"] a[aria-label="Camera ${other.id}"]`);
      await becomes(() => placeOf(page), (place) => other.places.includes(place));

      // Click on the middle of the timeline.
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
      // Escape and its button lead back to the previous page.
      await press(page, byId('back-to-live'));
      await page.waitForSelector(byId('camera-picture-1'));
    }));

    onView(`compares, and leads to what differs (${view})`, withPage(viewport, '#/recordings', options, async (page) => {
      const name = await makeClip('compared');
      const frames = await openClip(page, name);
      const count = frames.cameras[0].places.length;
      await press(page, byId('compare-recorded_settings'));
      await textBecomes(page, 'compare-result', new RegExp(`^Nothing differs in ${count} frames\\.$`));
      // The mask now leaves almost nothing, so all detections are lost.
      await service.patch({ op: 'replace', path: '/cameras/0/mask', value: { include: [{ points: [[0, 0], [2, 0], [2, 2]] }], exclude: [] } });
      await press(page, byId('compare-settings_now'));
      await textBecomes(page, 'compare-result', /^\d+ of \d+ frames differ: .*\d+ lost/);
      const { result } = await ask('recordings/compare');
      const { place, time_s: first } = result.differences.find(({ kind }) => kind === 'lost');
      await press(page, `${byId('difference')}[data-place="${place}"] >> nth=0`);
      await placeBecomes(page, place);
      assert.equal(await page.locator(`${byId('difference-ring')}[data-kind="lost"]`).count(), result.differences.filter((one) => one.place === place && one.kind === 'lost').length);
      // From there to the next one with a button, and back.
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
    await page.selectOption(`${byId('speed')} select`, '0.1'); // slow, so that it is still playing when checked
    await page.locator(`${byId('speed')} select`).blur();
    await page.keyboard.press(' ');
    await page.waitForSelector(`${byId('play')}[data-playing="true"]`);
    await page.keyboard.press(' ');
    await page.waitForSelector(`${byId('play')}[data-playing="false"]`);
    // The same on the timeline, which has a value for screen readers.
    await page.focus(byId('timeline'));
    await page.keyboard.press('End');
    await placeBecomes(page, places.at(-1));
    // The page itself determines where this camera lost robots, and can jump to these frames.
    const all = await Promise.all(places.map((place) => ask(`${clipPath(name)}/frames/${place}`)));
    const keys = ({ robots }) => robots.map((robot) => `${robot.team} ${robot.id}`);
    const lost = all.flatMap((frame, i) => (i > 0 && keys(all[i - 1]).some((key) => !keys(frame).includes(key)) ? [i] : []));
    if (lost.length) {
      await page.waitForSelector(`${byId('jump-to')} option[value="lost"]`, { state: 'attached' });
      await page.selectOption(`${byId('jump-to')} select`, 'lost');
      // Once all frames are known, the last loss is the event before the end.
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
    // Back to the recorded past.
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

    // All answers are held back for one second.
    const asked = new Set();
    const onTheWay = new Set(); // without those that the page has cancelled
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
      await route.continue().catch(() => {}); // the page has cancelled it
    });
    await page.clock.pauseAt(await page.evaluate(() => Date.now() + 600_000)); // far enough ahead that it is not yet past
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
    await textBecomes(page, 'compare-result', /^(Nothing differs in \d+ frame|\d+ of \d+ frames? differ)/);
    const compared = await ask('recordings/compare');
    assert.match(compared.clip, /try_colours/);
    assert.equal(compared.with, 'learnt_colors');
    assert.equal(compared.camera, 0);
    await page.waitForSelector(`${byId('compare')} >> text=The learnt colours are not in use yet`);
    // The learnt colours are still pending, and a reload of the player does not repeat the comparison.
    assert.doesNotMatch(page.url(), /learnt/);
    await page.click(`${byId('compare')} a:has-text("Accept or reject them")`);
    await page.waitForSelector(`${byId('learning')}[data-learnt="true"]`);
    await page.click(byId('learn-reject'));
    await page.waitForSelector(byId('learning'), { state: 'detached' });
  }));

  it('says in one line that its clip is gone', withPage(DESKTOP, '#/recordings', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs each 404
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
      await textBecomes(page, 'log-referee', /No game controller message at this moment/);
      assert.deepEqual(await layoutFaults(page), []);
      await accessibleInThemes(page, 'a log that is played');
    } finally {
      await ask(`recordings/logs/${encodeURIComponent(log.name)}`, { method: 'DELETE' });
    }
  }));
});
