// SPDX-License-Identifier: Apache-2.0
// The panel in a real browser, for tests that look at it as a user does.
//   SSLV_CHROMIUM       the browser; default: the system's
//   SSLV_SCREENSHOTS=1  also takes the pictures in docs/images
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, it } from 'node:test';
import { PATIENCE_MS, root } from './service.mjs';

const require = createRequire(join(root, 'webui/package.json'));
const { chromium } = require('playwright-core');
const axeSource = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

const PICTURES_HZ = 5;
const CHROMIUM = process.env.SSLV_CHROMIUM ?? '/usr/bin/chromium';
export const DESKTOP = { width: 1440, height: 900 };
export const PHONE = { width: 360, height: 740 };

export const byId = (name) => `[data-testid="${name}"]`;
export const live = (page) => page.waitForSelector(`${byId('connection')}[data-state="live"]`);
export const text = (page, name) => page.textContent(byId(name));
/**
 * The page has the answer to its last change. To be asked for once the service has the change, or for the first change
 * of a page: else it may be true of the one before.
 */
export const saved = (page) => page.waitForSelector(`${byId('save-state')}[data-state="saved"]`, { state: 'attached' });
// What page.waitForFunction() runs must not throw while the page is still without the element: that ends the wait.
/** Waits until a name's text, without spaces around it, is like that. */
export const textBecomes = (page, name, pattern) => page.waitForFunction(
  ([selector, source]) => new RegExp(source, 's').test(document.querySelector(selector)?.textContent.trim() ?? ''), [byId(name), pattern.source]);
/** Freezes the picture; none that was on its way comes after that. */
export async function freezePicture(page) {
  await page.click(byId('freeze'));
  await page.waitForSelector(`${byId('freeze')}[aria-pressed="true"]`);
}

/**
 * What is shown for some seconds only: `act` makes it come, and it is seen however busy the computer is. `pattern` is
 * of its text.
 */
export async function comesUp(page, selector, pattern, act) {
  await page.evaluate(([where, source]) => {
    window.cameUp = false;
    const look = () => { window.cameUp ||= [...document.querySelectorAll(where)].some(({ textContent }) => new RegExp(source).test(textContent)); };
    new MutationObserver(look).observe(document.body, { childList: true, subtree: true, characterData: true });
  }, [selector, pattern.source]);
  await act();
  await page.waitForFunction(() => window.cameUp);
}

export async function frameNumber(page, camera) {
  const picture = await page.waitForSelector(`${byId(`camera-picture-${camera}`)}[data-frame]`);
  return Number(await picture.getAttribute('data-frame'));
}

/** Waits until the camera's picture has gone on by so many frames. */
export async function picturesGoOn(page, camera, frames = 5) {
  const first = await frameNumber(page, camera);
  const way = await page.waitForFunction(
    ([selector, from, last]) => {
      const now = Number(document.querySelector(selector)?.dataset.frame);
      return now > last ? 'on' : now < from ? 'anew' : null;
    },
    [byId(`camera-picture-${camera}`), first, first + frames]);
  // A camera that was opened again counts anew.
  if (await way.jsonValue() === 'anew') await picturesGoOn(page, camera, frames);
}

/** What axe finds on a page, a line each. */
export async function axeFaults(page, rules = {}) {
  await page.evaluate(axeSource);
  const { violations } = await page.evaluate((options) => window.axe.run(document, { resultTypes: ['violations'], ...options }), rules);
  return violations.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.map((node) => `${node.target.join(' ')} ${node.failureSummary}`).join(', ')}`);
}

export async function accessible(page, what, rules = {}) {
  assert.deepEqual(await axeFaults(page, rules), [], `accessibility of ${what}`);
}

/** In both themes. They differ in colours only, so the second look is at these. */
export async function accessibleInThemes(page, what) {
  await chooseTheme(page, 'dark');
  await accessible(page, `${what}, dark`);
  await chooseTheme(page, 'light');
  await accessible(page, `${what}, light`, { runOnly: ['color-contrast', 'link-in-text-block'] });
}

export async function chooseTheme(page, theme) {
  if ((await page.getAttribute('html', 'data-theme')) !== theme) await page.click(byId('theme'));
  await page.waitForSelector(`html[data-theme="${theme}"]`);
}

export const phone = { hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
/** Names of tests without their views', in the order in which they came. */
const repeated = [];
const byTurns = (view, place) => (name, ...rest) => {
  const test = name.replace(view, '');
  if (!repeated.includes(test)) repeated.push(test);
  if (process.env.SSLV_VIEWS === 'all' || repeated.indexOf(test) % 2 === place) it(name, ...rest);
};
/**
 * What tests are repeated on, with an `it` of its own: ./run test does each on one view only, by turns, and
 * ./run test-long (SSLV_VIEWS=all) on both. Browsers that draw in software are what its time goes to, and panel_walk
 * looks at all pages on both.
 */
export const views = [
  { name: 'desktop', viewport: DESKTOP, options: {}, it: byTurns('desktop', 0) },
  { name: 'phone', viewport: PHONE, options: phone, it: byTurns('phone', 1) },
];

/**
 * A test that takes long for what it finds beyond what others do: only ./run test-long does it. Such are those that only
 * ask whether a page is accessible, which panel_walk asks of all pages.
 */
export const itLong = process.env.SSLV_VIEWS === 'all' ? it : () => {};

/** `webgl`: with a drawing machine made of software. */
export const launch = ({ webgl = false } = {}) => chromium.launch({
  executablePath: CHROMIUM,
  timeout: PATIENCE_MS,
  chromiumSandbox: process.getuid() !== 0,
  args: [...(webgl ? ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing'] : ['--disable-gpu']), '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});

/**
 * Runs in the page: of the service's status it takes out that this computer is too slow. On a busy one that would be
 * NO-GO, and alerts that take room from what is looked at.
 */
function leaveOutThisComputer() {
  const SLOW = ['camera_slow', 'frames_dropped', 'stage_slow'];
  function leaveOut(text) {
    const message = JSON.parse(text);
    if (message.topic !== 'status') return text;
    const { data } = message;
    const slow = data.alerts.filter(({ id }) => SLOW.includes(id));
    data.alerts = data.alerts.filter((alert) => !slow.includes(alert));
    // A check's text is the title of its worst alert.
    for (const check of data.checks)
      if (check.id === 'latency' || slow.some(({ title }) => check.text.startsWith(title))) check.state = 'pass';
    data.go = data.checks.every(({ state }) => state !== 'fail');
    return JSON.stringify(message);
  }
  const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage');
  Object.defineProperty(WebSocket.prototype, 'onmessage', {
    set(listener) { set.call(this, ({ data }) => listener({ data: typeof data === 'string' ? leaveOut(data) : data })); },
  });
}

/** Runs in the page: it gives no request up sooner than a test would. What no network answers still fails at once. */
function bePatient(patience_ms) {
  const { timeout } = AbortSignal;
  AbortSignal.timeout = (ms) => timeout.call(AbortSignal, Math.max(ms, patience_ms));
}

/** A browser on the panel of a service. */
export function createBrowser(service, { webgl = false } = {}) {
  const { address } = service;
  let browser;
  // A picture takes the browser longer than the service, and more of them show nothing more.
  if (!process.env.SSLV_SCREENSHOTS) for (const { source } of service.settings.cameras) source.frame_rate_hz = Math.min(source.frame_rate_hz, PICTURES_HZ);

  /**
   * A page, with its errors and its words to other hosts as they come, the newest detections that it was told, and what
   * came with the newest pictures.
   */
  async function openPage(viewport, options = {}) {
    // Half-way through a fade no colour is what it is meant to be.
    const context = await browser.newContext({ viewport, colorScheme: 'dark', reducedMotion: 'reduce', ...options });
    context.setDefaultTimeout(PATIENCE_MS);
    await context.addInitScript(leaveOutThisComputer);
    await context.addInitScript(bePatient, PATIENCE_MS);
    const page = await context.newPage();
    const panel = { page, errors: [], strangers: [], detections: [], previews: [], errorsExpected: false };
    page.on('console', (message) => {
      const { url } = message.location();
      // A camera that is found may be another test's, and gone when its image is asked for.
      if (message.type() === 'error' && !panel.errorsExpected && !url.includes('/api/sources/image')) panel.errors.push(`${message.text()} ${url}`);
    });
    page.on('pageerror', (error) => panel.errors.push(String(error)));
    const listen = (url) => {
      if (!['data:', 'blob:'].includes(new URL(url).protocol) && new URL(url).host !== new URL(address('')).host) {
        panel.strangers.push(url);
      }
    };
    page.on('request', (request) => listen(request.url()));
    page.on('websocket', (socket) => {
      listen(socket.url());
      socket.on('framereceived', ({ payload }) => {
        const isPreview = typeof payload !== 'string';
        const { topic, data } = isPreview ? { data: JSON.parse(payload.subarray(4, 4 + payload.readUInt32LE(0))) } : JSON.parse(payload);
        if (!isPreview && topic !== 'detections') return;
        const kept = isPreview ? panel.previews : panel.detections;
        kept.push(data);
        if (kept.length > 1000) kept.shift();
      });
    });
    return panel;
  }

  /** Gives a test an open page and closes it. An error in the console or a word to another host fails the test. */
  function withPage(viewport, path, options, test) {
    return async () => {
      const panel = await openPage(viewport, options);
      try {
        const answer = await panel.page.goto(address(path));
        assert.equal(answer.status(), 200);
        await live(panel.page);
        await test(panel.page, panel, answer);
      } finally {
        await panel.page.context().close();
      }
      assert.deepEqual(panel.errors, [], 'errors in the browser console');
      assert.deepEqual(panel.strangers, [], 'requests to other hosts');
    };
  }

  /** Takes pictures for docs/images: {file, theme, path, viewport, options, ready(page)}. */
  function screenshots(shots) {
    if (process.env.SSLV_SCREENSHOTS !== '1') return;
    const images = join(root, 'docs/images');
    for (const { file, theme, path, viewport, options, ready } of shots) {
      it(`docs/images/${file}`, withPage(viewport, path, options, async (page) => {
        await chooseTheme(page, theme);
        await ready?.(page);
        mkdirSync(images, { recursive: true });
        await page.screenshot({ path: join(images, file), quality: 88 });
      }));
    }
  }

  async function open(prepare = () => {}) {
    browser = await launch({ webgl });
    await service.start();
    await prepare();
  }
  async function close() {
    await browser?.close();
    await service.end();
  }

  /** For a suite: both run from before its first test until after its last. `prepare` comes last. */
  function aroundTests(prepare) {
    before(() => open(prepare));
    after(close);
  }

  return { aroundTests, close, open, openPage, withPage, screenshots };
}
