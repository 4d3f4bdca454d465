// SPDX-License-Identifier: Apache-2.0
// The panel from a user's point of view: the real service with its simulated cameras, in a real browser.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { beforeEach, describe, it } from 'node:test';
import { accessible, accessibleInThemes, byId, chooseTheme, createBrowser, DESKTOP, frameNumber, freezePicture, itLong, live, PHONE, phone, picturesGoOn, text, textBecomes, views } from './browser.mjs';
import { createService, root } from './service.mjs';

const service = await createService('239.255.77.78');
const { settings, folder, address, patch, statusBecomes } = service;
const { aroundTests, withPage } = createBrowser(service);

/** Measures the image and its overlay. Runs in the browser, in one task, so that both belong to the same frame. */
function measure(camera) {
  const canvas = document.querySelector(`[data-testid="camera-picture-${camera}"]`);
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  const box = canvas.parentElement.querySelector('svg').viewBox.baseVal;
  const colour = (x, y) => {
    const at = (Math.floor((y / box.height) * height) * width + Math.floor((x / box.width) * width)) * 4;
    return [data[at], data[at + 1], data[at + 2]];
  };
  let green = 0;
  let darkGrey = 0;
  for (let i = 0; i < data.length; i += 4) {
    const [r, g, b] = [data[i], data[i + 1], data[i + 2]];
    if (g > r + 12 && g > b + 12) green++;
    if (Math.max(r, g, b) < 70 && Math.max(r, g, b) - Math.min(r, g, b) < 12) darkGrey++;
  }

  const robots = [...canvas.parentElement.querySelectorAll('[data-testid="overlay-robot"]')].map((mark) => {
    const ring = mark.querySelector('.ring').getAttribute('d').split('Z')[0];
    const points = ring.slice(1).split('L').map((point) => point.split(' ').map(Number));
    const mean = (axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length;
    const [x, y] = [mean(0), mean(1)];
    // No pixels outside the camera's image.
    const inside = x > 4 && y > 4 && x < box.width - 4 && y < box.height - 4;
    // Also checks the neighbouring pixels: in a small JPEG the centre of a dot may be paler than its edge.
    const next = [-1, 0, 1].map((pixels) => (pixels * box.width) / width);
    const colours = next.flatMap((down) => next.map((right) => colour(x + right, y + down)));
    return { team: mark.dataset.team, id: Number(mark.dataset.id), camera: Number(mark.dataset.camera), x, y, colours: inside ? colours : null };
  });

  // Difference in brightness between the drawn lines and the image beside them.
  const path = canvas.parentElement.querySelector('[data-testid="overlay-lines"]');
  const bright = { on: 0, beside: 0 };
  if (path) {
    const length = path.getTotalLength();
    const samples = 2000;
    const beside = 8; // image pixels on both sides
    for (let i = 0; i < samples; i++) {
      const { x, y } = path.getPointAtLength((i / samples) * length);
      if (x < beside || y < beside || x >= box.width - beside || y >= box.height - beside) continue;
      const grey = (u, v) => colour(u, v).reduce((sum, value) => sum + value, 0) / 3;
      bright.on += grey(x, y) / samples;
      bright.beside += (grey(x - beside, y - beside) + grey(x + beside, y + beside)) / 2 / samples;
    }
  }
  return {
    frame: Number(canvas.dataset.frame), width, height, turn: Number(canvas.dataset.turn), green: green / (width * height), darkGrey: darkGrey / (width * height), robots,
    lines: bright.on - bright.beside,
  };
}

// Yellow next to other dots is paler in a small JPEG; carpet, lines, covers and pink dots stay below these bounds.
const hasColourOf = { blue: ([r, , b]) => b > r + 25, yellow: ([r, g, b]) => r > b + 40 && g > b + 20 };

function assertTeamColours({ robots, frame, width }) {
  for (const { team, id, x, y, colours } of robots) {
    assert.ok(colours === null || colours.some(hasColourOf[team]),
      `frame ${frame}: under ${team} ${id} at ${x.toFixed(1)}, ${y.toFixed(1)} the picture of ${width} px is rgb(${colours?.join("), rgb(")})`);
  }
}

/** The camera pixel shown at a place of an image that was rotated clockwise `turn` times by 90 degrees. */
function cameraPixel({ x, y }, { turn, width, height }) {
  for (let i = turn; i > 0; i--) [x, y] = [y, (i % 2 ? height : width) - x];
  return { x: x - 0.5, y: y - 0.5 };
}

/** Requests full resolution: in a smaller image, whose size depends on the rate at which images arrive, a dot may be
 * only one or two pixels. */
async function showFull(page, camera) {
  await page.getByLabel('Size').selectOption({ label: 'Full' });
  await page.waitForFunction((selector) => document.querySelector(selector)?.width === 780, byId(`camera-picture-${camera}`));
}

/** All robots of the demo, as "blue 3". */
const everyRobot = ['blue', 'yellow'].flatMap((team) => {
  const { [`robots_${team}`]: count } = settings.cameras[0].source;
  return Array.from({ length: count }, (_, id) => `${team} ${id}`);
}).sort();
const named = (robots) => [...new Set(robots.map(({ team, id }) => `${team} ${id}`))].sort();

/** Waits until exactly the demo's robots are marked by this selector. */
async function everyRobotIsMarked(page, selector) {
  await page.waitForFunction(
    ([marks, expected]) => {
      const seen = new Set([...document.querySelectorAll(marks)].map(({ dataset }) => `${dataset.team} ${dataset.id}`));
      return [...seen].sort().join() === expected;
    },
    [selector, everyRobot.join()]);
}

/** Waits until an image of this kind is shown, "camera" or "labels". */
const pictureIs = (page, camera, kind) => page.waitForSelector(`${byId(`camera-picture-${camera}`)}[data-picture="${kind}"]`);

/** The centre of a robot's click target that no other target covers. */
async function freeTarget(page) {
  const handle = await page.waitForFunction((selector) => {
    for (const target of document.querySelectorAll(selector)) {
      const { left, top, width, height } = target.getBoundingClientRect();
      const [x, y] = [left + width / 2, top + height / 2];
      if (document.elementFromPoint(x, y) === target) return { x, y, team: target.dataset.team, id: target.dataset.id };
    }
    return null;
  }, byId('robot-target'));
  return handle.jsonValue();
}

const pages = [
  { name: 'Overview', path: '', ready: byId('camera-tile-1') },
  { name: 'Camera', path: '#/camera/0', ready: byId('robot-target') },
  { name: 'API', path: '#/api', ready: byId('api-route') },
];

describe('panel', () => {
  aroundTests();
  beforeEach(service.restore);

  for (const { name, viewport, options, it } of views) {
    it(`shows both cameras live on a ${name}`, withPage(viewport, '', options, async (page) => {
      for (const { id } of settings.cameras) {
        await page.waitForSelector(`${byId(`camera-tile-${id}`)}[data-state="running"]`);
        await picturesGoOn(page, id);
        const { green, width, height } = await page.evaluate(measure, id);
        assert.ok(green > 0.3, `${width} x ${height} pixels of camera ${id}: ${green} of them carpet`);
      }
      await everyRobotIsMarked(page, byId('overlay-robot'));
      await everyRobotIsMarked(page, byId('field-robot'));
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} px too wide`);
    }));
  }

  it('is served with a content security policy', withPage(DESKTOP, '', {}, async (page, panel, answer) => {
    assert.match(answer.headers()['content-security-policy'] ?? '', /default-src 'self'/);
  }));

  it('marks robots where the picture shows them', withPage(DESKTOP, '', {}, async (page) => {
    const looked = new Set();
    for (const { id } of settings.cameras) {
      await page.goto(address(`#/camera/${id}`));
      await showFull(page, id);
      for (let i = 0; i < 5; i++) {
        await picturesGoOn(page, id, 1);
        const seen = await page.evaluate(measure, id);
        assert.equal(seen.width, 780);
        assertTeamColours(seen);
        for (const robot of named(seen.robots.filter(({ colours }) => colours))) looked.add(robot);
        assert.deepEqual(seen.robots.filter(({ camera }) => camera !== id), []);
      }
    }
    assert.deepEqual([...looked].filter((robot) => !everyRobot.includes(robot)), [], 'robots that are not there');
    assert.ok(looked.size > 8, `only ${[...looked]} were looked at`);
  }));

  it('marks in a tile what was found in the frame that it shows', withPage(DESKTOP, '', {}, async (page, panel) => {
    for (const { id, source } of settings.cameras) {
      for (let i = 0; i < 5; i++) {
        await picturesGoOn(page, id, 1);
        const { frame, turn, robots: marks } = await page.evaluate(measure, id);
        const { robots } = panel.previews.find((one) => one.camera === id && one.frame === frame);
        assert.deepEqual(marks.map((mark) => `${mark.team} ${mark.id}`), robots.map((robot) => `${robot.team} ${robot.id}`), `frame ${frame}`);
        for (const [k, mark] of marks.entries()) {
          const { x, y } = cameraPixel(mark, { turn, ...source });
          const { team, id: number, pixel_x, pixel_y } = robots[k];
          assert.ok(Math.hypot(x - pixel_x, y - pixel_y) < 0.5, `frame ${frame}: ${team} ${number} is marked at ${x}, ${y}, and was found at ${pixel_x}, ${pixel_y}`);
        }
      }
    }
  }));

  it('draws on the field what was reported', withPage(DESKTOP, '', {}, async (page, panel) => {
    await everyRobotIsMarked(page, byId('field-robot'));
    const drawn = await page.evaluate(() => {
      const svg = document.querySelector('[data-testid="field"]');
      const toField = svg.getScreenCTM().inverse();
      return [...svg.querySelectorAll('[data-testid="field-robot"]')].map((mark) => {
        const { left, top, width, height } = mark.querySelector('.body').getBoundingClientRect();
        const { x, y } = new DOMPoint(left + width / 2, top + height / 2).matrixTransform(toField);
        return { ...mark.dataset, at: { x, y: -y } };
      });
    });
    for (const { team, id, x, y, at } of drawn) {
      const reports = panel.detections.flatMap(({ robots }) => robots).filter((robot) => robot.team === team && String(robot.id) === id);
      assert.ok(reports.some((robot) => robot.x.toFixed(1) === x && robot.y.toFixed(1) === y),
        `${team} ${id} at ${x}, ${y} was never reported`);
      // A robot's flat front shifts the centre of its outline slightly.
      assert.ok(Math.hypot(at.x - x, at.y - y) < 40, `${team} ${id} of ${x}, ${y} is drawn at ${at.x}, ${at.y}`);
    }
  }));

  it('shows figures and passing checks', withPage(DESKTOP, '', {}, async (page) => {
    for (const { id } of settings.cameras) {
      await page.waitForFunction((selector) => Number(document.querySelector(selector)?.textContent) > 0, byId(`fps-${id}`));
      await textBecomes(page, `fps-${id}`, /^\d+\.\d$/);
      for (const name of ['latency-p50', 'latency-p99']) await textBecomes(page, `${name}-${id}`, /^\d+(\.\d+)?$/);
      await textBecomes(page, `drops-${id}`, /^[\d\u2009]+$/);
    }
    for (const check of ['robots', 'agreement', 'coverage', 'cameras', 'calibration', 'other_visions', 'teams']) await page.waitForSelector(`${byId(`check-${check}`)}[data-state="pass"]`);
    // Clock, load and unused network cards depend on this machine, so these checks may warn; but they must have a
    // result.
    for (const check of ['latency', 'pictures', 'clock', 'computer', 'network']) await page.waitForSelector(`${byId(`check-${check}`)}:not([data-state="unknown"])`);
    await textBecomes(page, 'check-cameras', /2\s*of 2/);
    await page.waitForSelector(`${byId('verdict')}[data-go="true"]`);
    await textBecomes(page, 'seen', /^12 robots, 1 ball$/);
    assert.equal(await page.locator(`${byId('alert')}[data-severity="bad"]`).count(), 0);
  }));

  it('switches between dark and light', withPage(DESKTOP, '', {}, async (page) => {
    const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).slice(0, 3).map(Number));
    await chooseTheme(page, 'light');
    const light = await background();
    assert.ok(Math.min(...light) > 180, `light: ${light}`);
    await page.reload();
    await page.waitForSelector('html[data-theme="light"]');
    await live(page);
    await chooseTheme(page, 'dark');
    const dark = await background();
    assert.ok(Math.max(...dark) < 80, `dark: ${dark}`);
  }));

  it('goes from a tile to its camera and back', withPage(DESKTOP, '', {}, async (page) => {
    await page.click('a[aria-label="Open camera 1"]');
    await page.waitForURL(/#\/camera\/1$/);
    await picturesGoOn(page, 1);
    await page.goBack();
    await picturesGoOn(page, 0);
  }));

  it('shows a camera in full with its lines and robots in place', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    await showFull(page, 0);
    await page.waitForSelector(byId('overlay-robot'));
    await page.waitForSelector(byId('overlay-lines'), { state: 'attached' });
    const seen = await page.evaluate(measure, 0);
    assert.deepEqual([seen.width, seen.height], [780, 580]);
    assert.ok(seen.robots.length > 0);
    assertTeamColours(seen);
    assert.ok(seen.lines > 25, `on its lines the picture is brighter by ${seen.lines} grey levels only`);
    await page.click('button[aria-label^="Turn"]');
    await page.waitForFunction((selector) => document.querySelector(selector)?.height === 780, byId('camera-picture-0'));
    await picturesGoOn(page, 0);
    assertTeamColours(await page.evaluate(measure, 0));
  }));

  it('hides and shows layers', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    const attached = (selector) => page.waitForSelector(selector, { state: 'attached' });
    const detached = (selector) => page.waitForSelector(selector, { state: 'detached' });
    await attached(byId('overlay-robot'));
    await page.click(byId('layer-detections'));
    await detached(byId('overlay-robot'));
    assert.equal(await page.getAttribute(byId('layer-detections'), 'aria-pressed'), 'false');
    await page.click(byId('layer-detections'));
    await attached(byId('overlay-robot'));
    await page.click(byId('layer-lines'));
    await detached(byId('overlay-lines'));
    await page.keyboard.press('2');
    await attached(byId('overlay-lines'));
    await page.click(byId('layer-grid'));
    await attached('path.grid');
    await page.keyboard.press('h');
    for (const mark of ['path.grid', byId('overlay-robot'), byId('overlay-lines')]) await detached(mark);
    await page.keyboard.press('h');
    await attached(byId('overlay-lines'));
  }));

  it('shows how every pixel is labelled', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    await showFull(page, 0);
    await pictureIs(page, 0, 'camera');
    const camera = await page.evaluate(measure, 0);
    assert.ok(camera.green > 0.3 && camera.darkGrey < 0.1, `carpet ${camera.green}, dark grey ${camera.darkGrey}`);

    await page.click(byId('layer-labels'));
    await pictureIs(page, 0, 'labels');
    await page.waitForFunction((mark) => document.querySelectorAll(mark).length > 2, byId('overlay-robot'));
    const labels = await page.evaluate(measure, 0);
    assert.ok(labels.green < 0.03 && labels.darkGrey > 0.9, `green ${labels.green}, dark grey ${labels.darkGrey}`);
    assertTeamColours(labels); // the dots are where the detections are drawn
    assert.ok(labels.robots.some(({ colours }) => colours));
    await page.waitForSelector(byId('overlay-lines'), { state: 'attached' });
    await page.waitForSelector(`${byId('camera-picture-0')}[aria-label="Live colour labels of camera 0"]`);

    // When enlarged, cells stay squares; the camera's image is smoothed.
    const rendering = () => page.evaluate((selector) => getComputedStyle(document.querySelector(selector)).imageRendering, byId('camera-picture-0'));
    await page.click('button[aria-label="Zoom in"]');
    await page.waitForSelector('canvas.pixelated');
    assert.equal(await rendering(), 'pixelated');

    await page.keyboard.press('h');
    await pictureIs(page, 0, 'camera');
    assert.ok((await page.evaluate(measure, 0)).green > 0.3);
    assert.equal(await rendering(), 'auto');
    await page.keyboard.press('h');
    await pictureIs(page, 0, 'labels');
    await page.keyboard.press('7');
    await pictureIs(page, 0, 'camera');
    assert.ok((await page.evaluate(measure, 0)).green > 0.3);
    assert.equal(await page.getAttribute(byId('layer-labels'), 'aria-pressed'), 'false');
  }));

  it('says why the labels asked for do not come', withPage(DESKTOP, '#/camera/1', {}, async (page) => {
    await pictureIs(page, 1, 'camera');
    await freezePicture(page);
    await page.click(byId('layer-labels'));
    await page.waitForSelector(`${byId('picture-note')}:has-text("Unfreeze to see the labels")`);
    await page.click(byId('freeze'));
    await pictureIs(page, 1, 'labels');
    await page.waitForSelector(byId('picture-note'), { state: 'detached' });

    const { settings: { cameras } } = await (await fetch(address('api/settings'))).json();
    await patch({ op: 'replace', path: '/cameras/1/stack', value: [] });
    await pictureIs(page, 1, 'camera');
    await page.waitForSelector(`${byId('picture-note')}:has-text("The stack produces no labels")`);
    await patch({ op: 'replace', path: '/cameras/1/stack', value: cameras[1].stack });
    await pictureIs(page, 1, 'labels');
  }));

  it('freezes, zooms, tells about a robot and goes on', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    await picturesGoOn(page, 0);
    await page.waitForSelector(byId('robot-target'));
    await freezePicture(page);
    const frozen = await frameNumber(page, 0);
    const taken = (await statusBecomes(() => true)).cameras[0].frames;
    await statusBecomes(({ cameras }) => cameras[0].frames > taken + 30);
    assert.equal(await frameNumber(page, 0), frozen, 'the camera went on, the picture did not');

    const robot = await freeTarget(page);
    await page.mouse.click(robot.x, robot.y);
    const card = await page.waitForSelector(byId('robot-card'));
    assert.match(await card.textContent(), new RegExp(`${robot.team} ${robot.id}.*x.*mm.*heading.*°`, 's'));
    await page.mouse.move(5, 5);
    await card.waitForElementState('visible');

    const percent = async () => Number.parseInt(await text(page, 'zoom'), 10);
    const whole = await percent();
    await page.click('button[aria-label="Zoom in"]');
    await page.waitForFunction(([selector, last]) => Number.parseInt(document.querySelector(selector)?.textContent, 10) > last, [byId('zoom'), whole]);
    await page.click('button[aria-label="Show the whole image"]');
    await page.waitForFunction(([selector, last]) => Number.parseInt(document.querySelector(selector)?.textContent, 10) === last, [byId('zoom'), whole]);

    await page.click(byId('freeze'));
    await picturesGoOn(page, 0);
  }));

  it('saves a still', withPage(DESKTOP, '#/camera/1', {}, async (page) => {
    await picturesGoOn(page, 1);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(byId('still'))]);
    assert.match(download.suggestedFilename(), /^camera-1-.*\.jpg$/);
    const bytes = readFileSync(await download.path());
    assert.deepEqual([...bytes.subarray(0, 3), ...bytes.subarray(-2)], [0xff, 0xd8, 0xff, 0xff, 0xd9], 'a whole JPEG');
    assert.ok(bytes.length > 20_000, `${bytes.length} bytes`);

    await page.keyboard.press('7');
    await pictureIs(page, 1, 'labels');
    const [labels] = await Promise.all([page.waitForEvent('download'), page.click(byId('still'))]);
    assert.match(labels.suggestedFilename(), /^camera-1-labels-.*\.jpg$/);
    const size = await page.evaluate(async (jpeg) => {
      const { width, height } = await createImageBitmap(new Blob([new Uint8Array(jpeg)], { type: 'image/jpeg' }));
      return [width, height];
    }, [...readFileSync(await labels.path())]);
    assert.deepEqual(size, [780, 580]);
  }));

  it('tells about a tapped robot on a phone', withPage(PHONE, '#/camera/0', phone, async (page) => {
    await picturesGoOn(page, 0);
    await freezePicture(page);
    const robot = await freeTarget(page);
    await page.touchscreen.tap(robot.x, robot.y);
    const tag = `${robot.team === 'yellow' ? 'y' : 'b'}${robot.id}`;
    await page.waitForFunction(([selector, name]) => document.querySelector(`${selector} .tag`)?.textContent === name, [byId('robot-strip'), tag]);
    assert.match(await text(page, 'robot-strip'), /mm.*°.*confidence/s);
  }));

  for (const { name: view, viewport, options } of views) {
    for (const { name, path, ready } of pages) {
      itLong(`is accessible: ${name} on a ${view}`, withPage(viewport, path, options, async (page) => {
        await page.waitForSelector(ready, { state: 'attached' });
        await accessibleInThemes(page, `${name} on a ${view}`);
      }));
    }
  }

  it('describes the interface', withPage(DESKTOP, '#/api/Robot', {}, async (page) => {
    await page.waitForSelector(byId('api-route'));
    const { paths } = JSON.parse(readFileSync(join(root, 'docs/openapi.json'), 'utf8'));
    const routes = Object.entries(paths).flatMap(([path, methods]) => Object.keys(methods).map((method) => `${method.toUpperCase()}${path}`));
    const shown = await page.$$eval(`${byId('api-route')} h3`, (titles) => titles.map((title) => [...title.children].slice(0, 2).map((part) => part.textContent).join('')));
    assert.deepEqual(shown.sort(), routes.sort());
    await page.waitForFunction(() => document.getElementById('schema-Robot')?.getBoundingClientRect().top < innerHeight);
  }));

  it('says which camera is lost and why, until it is back', withPage(DESKTOP, '', {}, async (page) => {
    await picturesGoOn(page, 1);
    const missing = join(folder, 'no-such-recording');
    await patch({ op: 'replace', path: '/cameras/1/source', value: { backend: 'files', path: missing } });
    const tile = `${byId('camera-tile-1')}[data-state="lost"]`;
    await page.waitForSelector(tile);
    await page.waitForSelector(`${tile} ${byId('picture-trouble')}:has-text("Camera lost"):has-text(${JSON.stringify(missing)}):has-text("No such file")`);
    await page.waitForSelector(`${byId('check-cameras')}[data-state="fail"]`);
    await page.waitForSelector(`${byId('verdict')}[data-go="false"]`);
    await textBecomes(page, 'verdict-reason', /^Camera 1 is lost/);
    const alert = `${byId('alert')}[data-severity="bad"]:has-text("Camera 1 is lost")`;
    assert.equal(await page.getAttribute(`${byId('check-cameras')} a`, 'href'), await page.getAttribute(`${alert} a`, 'href'));
    assert.match(await page.textContent(alert), /Camera 1 is lost.*Fix/s);
    assert.equal(await page.locator(`${tile} ${byId('overlay-robot')}`).count(), 0, 'no old detections');
    await picturesGoOn(page, 0);
    await accessible(page, 'Overview with a lost camera');

    await page.click(`${alert} a`);
    await page.waitForSelector(`${byId('view')} ${byId('picture-trouble')}`);
    await page.click('a[href="#/overview"]');

    await patch({ op: 'replace', path: '/cameras/1/source', value: settings.cameras[1].source });
    await page.waitForSelector(`${byId('camera-tile-1')}[data-state="running"]`);
    await picturesGoOn(page, 1);
    await page.waitForSelector(`${byId('verdict')}[data-go="true"]`);
  }));

  it('comes back by itself when the service does', withPage(DESKTOP, '', {}, async (page, panel) => {
    for (const { id } of settings.cameras) await picturesGoOn(page, id);
    await page.evaluate(() => { window.notReloaded = true; });
    panel.errorsExpected = true;
    await service.stop();
    const lastFrames = {};
    for (const { id } of settings.cameras) lastFrames[id] = await frameNumber(page, id);
    await page.waitForSelector(`${byId('connection')}[data-state="stale"]`);
    await page.waitForSelector(byId('no-data'));
    await page.waitForSelector(`${byId('check-cameras')}[data-state="unknown"]`);
    await page.waitForSelector(byId('overlay-robot'), { state: 'detached' });
    assert.equal(await text(page, 'fps-0'), '–');
    assert.equal(await page.locator(byId('field-robot')).count(), 0);
    await accessible(page, 'Overview without the service');

    const port = settings.panel.port;
    await service.start();
    assert.equal(settings.panel.port, port);
    await live(page);
    panel.errorsExpected = false;
    for (const { id } of settings.cameras) {
      // The new service restarts the frame numbers, so higher numbers would prove nothing.
      await page.waitForFunction(([selector, old]) => ![undefined, String(old)].includes(document.querySelector(selector)?.dataset.frame),
        [byId(`camera-picture-${id}`), lastFrames[id]]);
      await picturesGoOn(page, id);
    }
    await everyRobotIsMarked(page, byId('overlay-robot'));
    await everyRobotIsMarked(page, byId('field-robot'));
    assert.equal(await page.evaluate(() => window.notReloaded), true);
  }));
});
