// SPDX-License-Identifier: Apache-2.0
// The page Calibration & masks from a user's point of view: the real service with its simulated cameras, in a real
// browser.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { join } from 'node:path';
import { beforeEach, describe, it } from 'node:test';
import { accessibleInThemes, byId, comesUp, createBrowser, DESKTOP, freezePicture, itLong, picturesGoOn, saved, text, views } from './browser.mjs';
import { becomes, createService, freeUdpPort } from './service.mjs';

const service = await createService('239.255.77.80');
const { settings, address, patch, statusBecomes } = service;
const { aroundTests, withPage } = createBrowser(service);

const get = async (path) => (await fetch(address(path))).json();
const calibration = (camera = 0) => get(`api/cameras/${camera}/calibration`);

/** Waits until this text contains a number; checks it with `wanted` and returns it. */
async function numberBecomes(page, name, wanted) {
  await page.waitForFunction(([selector]) => /\d/.test(document.querySelector(selector)?.textContent ?? ''), [byId(name)]);
  const number = Number((await text(page, name)).replace('−', '-'));
  assert.ok(wanted(number), `${name} is ${number}`);
  return number;
}

/** Projects a point on the field to the camera's image, as in docs/protocol.md. */
function project(c, x, y, z = 0) {
  const { q0, q1, q2, q3 } = c;
  const s = 2 / (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3);
  const row = (a, b, d, t) => a * x + b * y + d * z + t;
  const px = row(1 - s * (q1 * q1 + q2 * q2), s * (q0 * q1 - q2 * q3), s * (q0 * q2 + q1 * q3), c.tx);
  const py = row(s * (q0 * q1 + q2 * q3), 1 - s * (q0 * q0 + q2 * q2), s * (q1 * q2 - q0 * q3), c.ty);
  const pz = row(s * (q0 * q2 - q1 * q3), s * (q1 * q2 + q0 * q3), 1 - s * (q0 * q0 + q1 * q1), c.tz);
  const ru = Math.hypot(px, py) / pz;
  let rd = ru;
  for (let i = 0; i < 50; i++) rd = ru / (1 + c.distortion * rd * rd);
  const scale = (c.focal_length * rd) / ru / pz;
  return { x: px * scale + c.principal_point_x, y: py * scale + c.principal_point_y };
}
const truth = settings.cameras[0].calibration;
const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

const press = (view) => (view === 'phone' ? 'tap' : 'click');

/** Screen coordinates of an image pixel. */
async function onScreen(page, { x, y }) {
  const canvas = page.locator(byId('camera-picture-0'));
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  const { width, height } = settings.cameras[0].source;
  return { x: box.x + ((x + 0.5) / width) * box.width, y: box.y + ((y + 0.5) / height) * box.height };
}

/** Drags by mouse or, through Chromium's touch events, by finger. Returns a function that releases. */
async function drag(page, from, to, finger) {
  const steps = 6;
  const at = (i) => ({ x: from.x + ((to.x - from.x) * i) / steps, y: from.y + ((to.y - from.y) * i) / steps });
  if (!finger) {
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    for (let i = 1; i <= steps; i++) await page.mouse.move(at(i).x, at(i).y);
    return () => page.mouse.up();
  }
  const session = await page.context().newCDPSession(page);
  const send = (type, points) => session.send('Input.dispatchTouchEvent', { type, touchPoints: points });
  await send('touchStart', [from]);
  for (let i = 1; i <= steps; i++) await send('touchMove', [at(i)]);
  return async () => {
    await page.waitForTimeout(300); // holds still: after a fling, the browser uses the next tap to stop it
    await send('touchEnd', []);
  };
}

/** The robots that camera 0 reported in at least `pictures` images taken after that status. */
async function robotsSince({ time }, panel, pictures = 20) {
  // The page itself does not ask for detections.
  await panel.page.evaluate(() => {
    const url = new URL('api/ws', document.baseURI);
    url.protocol = 'ws:';
    url.hash = '';
    window.detectionsSocket = new WebSocket(url.href);
    window.detectionsSocket.onopen = () => window.detectionsSocket.send('{"subscribe": ["detections"]}');
  });
  const fresh = await becomes(() => panel.detections.filter(({ camera, t_capture }) => camera === 0 && t_capture > time), ({ length }) => length >= pictures,
    ({ length }) => `${length} pictures`);
  await panel.page.evaluate(() => window.detectionsSocket.close());
  return fresh.flatMap(({ robots }) => robots);
}

const verdict = (page) => page.waitForSelector(byId('verdict'));

// A game controller runs in a later test.
settings.network.referee = { enabled: true, group: '239.255.77.81', port: await freeUdpPort(), interface: 'lo' };

describe('calibration page', () => {
  aroundTests();
  beforeEach(service.restore);

  for (const { name: view, viewport, options, it } of views) {
    it(`finds a camera that is not calibrated by itself, on a ${view}`, withPage(viewport, '#/calibration/0', options, async (page, panel) => {
      const click = (selector) => page[press(view)](selector);
      const records = (await calibration()).history.length;
      await patch({ op: 'replace', path: '/cameras/0/calibration', value: null });
      await page.waitForSelector(`${byId('hint')}:has-text("not calibrated")`);
      await statusBecomes(({ cameras }) => cameras[0].robots === 0);
      await picturesGoOn(page, 0);

      await click(byId('find'));
      await verdict(page);
      assert.equal(await page.getAttribute(byId('verdict'), 'data-accepted'), 'true');
      await numberBecomes(page, 'figure-rms', (mm) => mm > 0 && mm < 1);
      await numberBecomes(page, 'figure-expected', (mm) => mm > 0 && mm < 1);
      await numberBecomes(page, 'figure-coverage', (percent) => percent > 50 && percent <= 100);
      assert.ok(await page.locator(byId('line-row')).count() >= 8);
      assert.ok(await page.locator(`${byId('error-map')} rect`).count() > 40);
      assert.equal((await calibration()).calibration, null, 'nothing is in use before it was accepted');

      // The new lines lie on the painted ones.
      const brightness = await page.evaluate(brighterOnLines, 0);
      assert.ok(brightness > 25, `on its lines the picture is brighter by ${brightness} grey levels only`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} px too wide`);

      await click(byId('accept'));
      await page.waitForSelector(byId('revert'));
      const { calibration: found, history } = await calibration();
      assert.equal(history.length, records + 1);
      for (const [x, y] of [[-4500, 3000], [-4500, -3000], [0, 0], [-2000, 500]]) {
        // A field looks the same from both ends, so without a hint the result may be rotated by 180 degrees.
        const both = [project(truth, x, y), project(truth, -x, -y)];
        assert.ok(Math.min(...both.map((at) => distance(at, project(found, x, y)))) < 0.3, `${x}, ${y}`);
      }
      const status = await statusBecomes(({ cameras }) => cameras[0].robots > 0);
      // Robots are reported where the image shows them, according to the calibration in use.
      const robots = await robotsSince(status, panel);
      assert.ok(robots.length > 0);
      for (const robot of robots) {
        assert.ok(distance(project(found, robot.x, robot.y, robot.height), { x: robot.pixel_x, y: robot.pixel_y }) < 1, JSON.stringify(robot));
      }

      await click(byId('revert'));
      await untilSaved(async () => (await calibration()).calibration === null);
      await page.waitForSelector(`${byId('record')}:has-text("reverted")`);
      await patch({ op: 'replace', path: '/cameras/0/calibration', value: truth });
    }));

    it(`finds better lines once a wrong corner was dragged, on a ${view}`, withPage(viewport, '#/calibration/0', options, async (page) => {
      const finger = view === 'phone';
      const click = (selector) => page[press(view)](selector);
      await patch({ op: 'replace', path: '/cameras/0/calibration', value: truth });
      await page.waitForSelector(byId('propose'));
      const right = { 'corner left top': [-4495, 2995], 'corner left bottom': [-4495, -2995], 'halfway line top': [0, 2995], 'halfway line bottom': [0, -2995] };
      // Two of four points are wrong, so nothing is accepted.
      const wrong = { 'corner left bottom': { x: 502, y: 410 }, 'halfway line bottom': { x: 600, y: 150 } };
      let count = 0;
      await picturesGoOn(page, 0, 1);
      await freezePicture(page); // a live image may be too old to accept points
      for (const [name, [x, y]] of Object.entries(right)) {
        const at = await onScreen(page, wrong[name] ?? project(truth, x, y));
        if (finger) await page.touchscreen.tap(at.x, at.y);
        else await page.mouse.click(at.x, at.y);
        count++;
        await page.waitForFunction(([selector, wanted]) => document.querySelectorAll(selector).length === wanted, [byId('point'), count]);
        await page.getByLabel(`Point ${count} shows`).selectOption(name);
      }
      await click(byId('run'));
      await verdict(page);
      assert.equal(await page.getAttribute(byId('verdict'), 'data-accepted'), 'false');
      const rms = await numberBecomes(page, 'figure-rms', (mm) => mm > 0);
      assert.ok(await page.locator(byId('problem')).count() > 0);

      // Points keep their order, whatever they were identified as.
      const index = 1;
      const target = byId('point');
      const place = project(truth, ...right['corner left bottom']);
      const [start, end] = [await onScreen(page, wrong['corner left bottom']), await onScreen(page, place)];
      const box = await page.locator(target).nth(index).boundingBox();
      assert.ok(box.width >= 44 && box.height >= 44, 'a target for fingers');
      const drop = await drag(page, start, end, finger);
      const loupe = await page.waitForSelector(byId('loupe'));
      const glass = await loupe.boundingBox();
      assert.ok(end.x < glass.x || end.x > glass.x + glass.width || end.y < glass.y || end.y > glass.y + glass.height, 'the magnifier is away from the finger');
      await drop();
      await click(byId('step-points'));
      await page.getByLabel('Point 2 shows').selectOption('corner left bottom');
      for (const [i, name] of [[1, 'corner left top'], [3, 'halfway line top']]) await page.getByLabel(`Point ${i} shows`).selectOption(name);
      await page.getByLabel('Point 4 shows').selectOption('halfway line bottom');
      await click(byId('step-look'));
      await click(byId('again'));
      await page.waitForSelector(`${byId('verdict')}[data-accepted="true"]`);
      // The first run may have found the lines despite the wrong corners and rejected only these: rms was then low
      // already.
      await numberBecomes(page, 'figure-rms', (mm) => mm < Math.max(0.5, rms / 10));
      // The other wrong point is reported.
      await page.waitForSelector(`${byId('problem')}:has-text("Point 4")`);
      await click(byId('reject'));
      await page.waitForSelector(byId('verdict'), { state: 'detached' });
      assert.equal((await calibration()).state, 'idle');
    }));

    it(`masks a part of the picture, on a ${view}`, withPage(viewport, '#/calibration/0', options, async (page, panel) => {
      const finger = view === 'phone';
      const click = (selector) => page[press(view)](selector);
      const mask = async () => (await get('api/settings')).settings.cameras[0].mask;
      await patch({ op: 'replace', path: '/cameras/0/calibration', value: truth });
      await statusBecomes(({ cameras }) => cameras[0].robots > 0);
      await click(byId('mode-masks'));
      const before = await get('api/settings');
      const changes = [];
      page.on('request', (request) => { if (request.method() !== 'GET') changes.push(`${request.method()} ${request.url()}`); });
      const corner = async (x, y) => {
        // The panel ignores clicks on an outdated image, which a busy computer may cause.
        await picturesGoOn(page, 0, 1);
        const at = await onScreen(page, { x, y });
        const count = await page.locator(byId('drawn-corner')).count();
        if (finger) await page.touchscreen.tap(at.x, at.y);
        else await page.mouse.click(at.x, at.y);
        await page.waitForFunction(([selector, n]) => document.querySelectorAll(selector).length === n, [byId('drawn-corner'), count + 1]);
      };
      // The service never sees an unfinished drawing: with three corners, or after cancelling.
      await click(byId('add-exclude'));
      await page.waitForSelector(byId('drawing'));
      assert.ok(await page.isDisabled(byId('finish-drawing')));
      await page.keyboard.press('Enter');
      for (const [x, y] of [[200, 200], [400, 200], [400, 400]]) await corner(x, y);
      assert.ok(await page.isEnabled(byId('finish-drawing')));
      await page.keyboard.press('Escape');
      await page.waitForSelector(byId('drawing'), { state: 'detached' });
      assert.equal(await page.locator(byId('polygon-row')).count(), 0);
      assert.equal(await page.evaluate(() => document.activeElement.dataset.testid), 'add-exclude');
      assert.deepEqual(changes, []);
      assert.equal((await get('api/settings')).revision, before.revision);

      // By keyboard alone.
      await page.keyboard.press('Enter');
      await page.waitForFunction((selector) => document.activeElement?.matches(selector), byId('pen'));
      for (const way of ['ArrowLeft', 'ArrowDown', 'ArrowRight']) {
        for (let i = 0; i < 4; i++) await page.keyboard.press(`Shift+${way}`);
        await page.keyboard.press('Space');
      }
      assert.deepEqual(changes, []);
      await page.keyboard.press('Enter');
      await untilSaved(async () => (await mask()).exclude.length === 1);
      assert.deepEqual((await mask()).exclude[0].points, [[310, 290], [310, 370], [390, 370]]);
      await click(byId('delete-polygon'));
      await untilSaved(async () => (await mask()).exclude.length === 0);

      await click(byId('add-exclude'));
      for (const [x, y] of [[200, 200], [500, 200], [500, 400], [200, 400]]) await corner(x, y);
      await click(byId('finish-drawing'));
      await untilSaved(async () => (await mask()).exclude.length === 1);
      await saved(page);
      const [first] = (await mask()).exclude;
      assert.equal(first.points.length, 4);

      // Drag its corners to those of the image: then the whole image is hidden.
      const corners = [[1, 1], [778, 1], [778, 578], [1, 578]];
      for (const [i, [x, y]] of corners.entries()) {
        // Wait until the page has the last save and shows a live image: a frozen one has no magnifier.
        await saved(page);
        await picturesGoOn(page, 0, 1);
        const now = (await mask()).exclude[0].points[i];
        const drop = await drag(page, await onScreen(page, { x: now[0], y: now[1] }), await onScreen(page, { x, y }), finger);
        await page.waitForSelector(byId('loupe'));
        await drop();
        await untilSaved(async () => distance(pair((await mask()).exclude[0].points[i]), { x, y }) < 4);
      }
      const status = await statusBecomes(({ cameras }) => cameras[0].robots === 0 && cameras[0].balls === 0);
      assert.deepEqual(await robotsSince(status, panel), []);
      // Hidden parts are dark in the label image.
      await click(byId('mask-labels'));
      await page.waitForSelector(`${byId('camera-picture-0')}[data-picture="labels"]`);
      // The corners are up to 4 px from those of the image, so a strip of it remains visible.
      const left = await page.evaluate(colourful, 0);
      assert.ok(left < 0.001, `${left} of the labelled picture have a colour`);
      await click(byId('mask-labels'));

      // The keyboard moves a corner, and a click on an edge adds one.
      const at = (await mask()).exclude[0].points[0];
      await page.locator(byId('corner')).first().focus();
      await page.keyboard.press('Shift+ArrowRight');
      await page.keyboard.press('ArrowDown');
      await untilSaved(async () => distance(pair((await mask()).exclude[0].points[0]), { x: at[0] + 10, y: at[1] + 1 }) < 0.2);
      const middle = await page.locator(byId('edge')).first().boundingBox();
      const centre = [middle.x + middle.width / 2, middle.y + middle.height / 2];
      if (finger) await page.touchscreen.tap(...centre);
      else await page.mouse.click(...centre);
      await untilSaved(async () => (await mask()).exclude[0].points.length === 5);
      await page.locator(byId('corner')).nth(1).focus();
      await page.keyboard.press('Delete');
      await untilSaved(async () => (await mask()).exclude[0].points.length === 4);

      await click(byId('delete-polygon'));
      await untilSaved(async () => (await mask()).exclude.length === 0);
      await statusBecomes(({ cameras }) => cameras[0].robots > 0);
      // Undo reverts only the changes made on this page.
      const beyond = async (value) => {
        await service.patch({ op: 'replace', path: '/cameras/0/mask/beyond_boundary', value });
        await page.waitForFunction((text) => document.querySelector('[data-testid="setting-/cameras/0/mask/beyond_boundary"] input[inputmode]').value === text, String(value));
      };
      const { beyond_boundary: unset } = await mask();
      await beyond(250);
      await click(byId('mask-undo'));
      await untilSaved(async () => (await mask()).exclude.length === 1);
      assert.equal((await mask()).beyond_boundary, 250);
      await beyond(unset);
      await click(byId('delete-polygon'));
      await click(byId('add-around'));
      await untilSaved(async () => (await mask()).include.length === 1 && (await mask()).exclude.length === 0);
      await statusBecomes(({ cameras }) => cameras[0].robots > 0);
      await click(byId('delete-polygon'));
      await untilSaved(async () => (await mask()).include.length === 0);

      // The hall beyond the boundary is hidden automatically, from the distance that is set.
      const row = '[data-testid="setting-/cameras/0/mask/beyond_boundary"]';
      const hiddenPx = async () => (await get('api/cameras/0/field_view')).hidden.reduce((sum, [, , width, height]) => sum + width * height, 0);
      const shown = () => page.locator(byId('beyond')).getAttribute('d');
      const [usual, drawn] = [await hiddenPx(), await shown()];
      await page.locator(`${row} input[type="number"], ${row} input[inputmode]`).first().fill('100');
      await page.keyboard.press('Enter');
      await untilSaved(async () => (await mask()).beyond_boundary === 100);
      assert.ok(await hiddenPx() < usual, 'less is left out');
      await untilSaved(async () => await shown() !== drawn);
      await patch({ op: 'replace', path: '/cameras/0/mask/beyond_boundary', value: null });
      assert.equal(await hiddenPx(), 0);
      await untilSaved(async () => await shown() === '');
      await patch({ op: 'replace', path: '/cameras/0/mask/beyond_boundary', value: 0 });
    }));

    for (const mode of ['calibrate', 'together', 'masks']) {
      itLong(`is accessible: ${mode} on a ${view}`, withPage(viewport, '#/calibration/0', options, async (page) => {
        await page[press(view)](byId(`mode-${mode}`));
        await picturesGoOn(page, 0, 1);
        const states = mode === 'calibrate' ? ['step-points', 'step-known', 'step-history'] : mode === 'masks' ? ['add-exclude'] : ['mode-together'];
        for (const state of states) {
          await page[press(view)](byId(state));
          await accessibleInThemes(page, `${mode}, ${state} on a ${view}`);
        }
        if (mode !== 'masks') return;
        await page.keyboard.press('Escape');
        await page[press(view)](byId('add-around'));
        await page.waitForSelector(byId('corner'));
        await accessibleInThemes(page, `masks, a polygon on a ${view}`);
        await page[press(view)](byId('delete-polygon'));
        await untilSaved(async () => (await get('api/settings')).settings.cameras[0].mask.include.length === 0);
      }));
    }
  }

  it('sends known values, shows progress and is accessible', withPage(DESKTOP, '#/calibration/1', {}, async (page) => {
    await page.click(byId('step-known'));
    await page.getByLabel('Height above the floor in mm').fill('50');
    await page.keyboard.press('Enter');
    await page.waitForSelector('text=Must be at least 100');
    await page.getByLabel('Height above the floor in mm').fill('4000');
    await page.keyboard.press('Enter');
    await page.getByRole('radiogroup', { name: 'Part of the line that field sizes are measured to' }).getByText('Centre').click();
    await comesUp(page, byId('progress'), /./, () => page.click(byId('find')));
    await verdict(page);
    const { request, report } = await calibration(1);
    assert.deepEqual([request.height_mm, request.height_sigma_mm, request.lines_measured_to], [4000, 20, 'middle']);
    assert.ok(Math.abs(report.height_mm - 4000) < 60);
    await accessibleInThemes(page, `the report`);
    await page.click(byId('view-in-use'));
    await page.waitForSelector(`${byId('view-in-use')}[aria-pressed="true"]`);
    await page.click(byId('reject'));
    await page.waitForSelector(byId('find'));
  }));

  it('calibrates both cameras together', withPage(DESKTOP, '#/calibration/0', {}, async (page) => {
    await page.click(byId('mode-together'));
    await page.getByLabel('Robot search time in s').fill('2');
    await page.keyboard.press('Enter');
    await page.click(byId('together-run'));
    await verdict(page);
    assert.equal(await page.locator(byId('together-row')).count(), 2);
    const { report } = await get('api/calibration');
    assert.equal(Number(await text(page, 'together-lines-after')).toFixed(2), report.on_floor.after_mm.toFixed(2));
    const records = (await calibration(1)).history.length;
    await page.click(byId('accept'));
    if (!report.accepted) await page.click(byId('force'));
    await page.waitForSelector(byId('together-accepted'));
    assert.equal((await calibration(1)).history.length, records + 1);
    for (const { camera, calibration: found } of report.cameras) assert.deepEqual((await calibration(camera)).calibration, found);
    await patch(...settings.cameras.map(({ calibration: old }, i) => ({ op: 'replace', path: `/cameras/${i}/calibration`, value: old })));
  }));

  it('refuses while the game runs, unless overridden', withPage(DESKTOP, '#/calibration/0', {}, async (page, panel) => {
    const { group, port } = settings.network.referee;
    const stop = await playGame(group, port);
    try {
      await page.waitForSelector(byId('game'));
      panel.errorsExpected = true; // the browser logs the refusal
      await page.click(byId('find'));
      await page.waitForSelector(`${byId('refused')}:has-text("the game is running")`);
      assert.equal((await calibration()).report, null);
      await page.click(byId('force'));
      await verdict(page);
      await page.click(byId('reject'));
      await page.waitForSelector(byId('find'));
    } finally {
      stop();
    }
    await page.waitForSelector(byId('game'), { state: 'detached' });
  }));

  it('says what to do with a camera that is lost, and with one that is not there', withPage(DESKTOP, '#/calibration/1', {}, async (page) => {
    await patch({ op: 'replace', path: '/cameras/1/source', value: { backend: 'files', path: join(service.folder, 'no-such-recording') } });
    await page.waitForSelector(`${byId('hint')}:has-text("sends no images")`);
    await page.waitForSelector(byId('picture-trouble'));
    await patch({ op: 'replace', path: '/cameras/1/source', value: settings.cameras[1].source });
    await page.waitForSelector(byId('hint'), { state: 'detached' });
    await page.goto(address('#/calibration/7'));
    await page.waitForSelector('text=There is no camera 7.');
  }));
});

const pair = ([x, y]) => ({ x, y });

/** Waits until `wanted` is true at the service. */
const untilSaved = (wanted) => becomes(wanted, Boolean, () => `not saved: ${wanted}`);

/** A game controller that repeats NORMAL_START. Returns a function that sends HALT and stops it. */
async function playGame(group, port) {
  const socket = createSocket('udp4');
  await new Promise((resolve) => { socket.bind(0, '127.0.0.1', resolve); });
  socket.setMulticastInterface('127.0.0.1');
  const varint = (value) => {
    const bytes = [];
    let rest = BigInt(value);
    do { bytes.push(Number(rest & 127n) | (rest > 127n ? 128 : 0)); rest >>= 7n; } while (rest);
    return bytes;
  };
  const number = (field, value) => [...varint(field * 8), ...varint(value)];
  const message = (field, bytes) => [...varint(field * 8 + 2), ...varint(bytes.length), ...bytes];
  const name = (words) => message(1, [...Buffer.from(words)]);
  const team = (words) => [...name(words), ...number(2, 0), ...number(3, 0), ...number(5, 0), ...number(6, 4), ...number(7, 300_000_000), ...number(8, 0)];
  let command = 2; // NORMAL_START
  const say = (sent) => {
    const now = BigInt(Date.now()) * 1000n;
    // SSL_Referee: packet_timestamp, stage NORMAL_FIRST_HALF, command, counter, time of the command, both teams.
    socket.send(Buffer.from([
      ...number(1, now), ...number(2, 1), ...number(4, command), ...number(5, 1), ...number(6, now), ...message(7, team('Yellow')), ...message(8, team('Blue')),
    ]), port, group, sent);
  };
  const timer = setInterval(say, 200);
  return () => {
    clearInterval(timer);
    command = 0; // HALT; the game would not end by silence alone
    say(() => socket.close());
  };
}

/**
 * Difference in brightness between a camera's image under the lines drawn over it and beside them; runs in the browser.
 * Uses the full resolution: the displayed image is smaller if images arrive late.
 */
async function brighterOnLines(camera) {
  const bitmap = await createImageBitmap(await (await fetch(`api/cameras/${camera}/snapshot.jpg`)).blob());
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  const path = document.querySelector(`[data-testid="camera-picture-${camera}"]`).parentElement.querySelector('[data-testid="overlay-lines"]');
  const box = path.ownerSVGElement.viewBox.baseVal;
  const grey = (x, y) => {
    const at = (Math.floor((y / box.height) * height) * width + Math.floor((x / box.width) * width)) * 4;
    return (data[at] + data[at + 1] + data[at + 2]) / 3;
  };
  const length = path.getTotalLength();
  const samples = 2000;
  const beside = 12;
  let [sum, count] = [0, 0];
  for (let i = 0; i < samples; i++) {
    const { x, y } = path.getPointAtLength((i / samples) * length);
    if (x < beside || y < beside || x >= box.width - beside || y >= box.height - beside) continue;
    sum += grey(x, y) - (grey(x - beside, y - beside) + grey(x + beside, y + beside)) / 2;
    count++;
  }
  return sum / count;
}

/** Share of the image's pixels that are coloured; runs in the browser. */
function colourful(camera) {
  const canvas = document.querySelector(`[data-testid="camera-picture-${camera}"]`);
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 60) count++;
  }
  return count / (data.length / 4);
}
