// SPDX-License-Identifier: Apache-2.0
// The panel in a real browser, for tests from a user's point of view.
//   SSLV_CHROMIUM       the browser; default: the system's without a window, which needs a third less CPU time
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, before, it } from 'node:test';
import { PATIENCE_MS, root } from './service.mjs';

const require = createRequire(join(root, 'webui/package.json'));
const { chromium } = require('playwright-core');
const axeSource = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

const PICTURES_HZ = 5;
const CHROMIUM = process.env.SSLV_CHROMIUM ?? '/usr/bin/chromium-headless-shell';
export const DESKTOP = { width: 1440, height: 900 };
export const PHONE = { width: 360, height: 740 };

export const byId = (name) => `[data-testid="${name}"]`;
export const live = (page) => page.waitForSelector(`${byId('connection')}[data-state="live"]`);
export const text = (page, name) => page.textContent(byId(name));
/**
 * Waits until the page has received the answer to its last change. Call it after the service has the change, or for the
 * page's first change: otherwise it may still report the previous one.
 */
export const saved = (page) => page.waitForSelector(`${byId('save-state')}[data-state="saved"]`, { state: 'attached' });
// Functions passed to page.waitForFunction() must not throw while the page lacks the element: a throw ends the wait.
/** Waits until the element's trimmed text matches. */
export const textBecomes = (page, name, pattern) => page.waitForFunction(
  ([selector, source]) => new RegExp(source, 's').test(document.querySelector(selector)?.textContent.trim() ?? ''), [byId(name), pattern.source]);
/** Freezes the image; returns when frames in transit can no longer replace it. */
export async function freezePicture(page) {
  await page.click(byId('freeze'));
  await page.waitForSelector(`${byId('freeze')}[aria-pressed="true"]`);
}

/**
 * Checks an element that is shown for a few seconds only, even on a busy computer: `act` triggers it, and its text must
 * match `pattern`.
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

/** Waits until the camera's image has advanced by so many frames. */
export async function picturesGoOn(page, camera, frames = 5) {
  const first = await frameNumber(page, camera);
  const way = await page.waitForFunction(
    ([selector, from, last]) => {
      const now = Number(document.querySelector(selector)?.dataset.frame);
      return now > last ? 'on' : now < from ? 'anew' : null;
    },
    [byId(`camera-picture-${camera}`), first, first + frames]);
  // A reopened camera restarts its frame numbers.
  if (await way.jsonValue() === 'anew') await picturesGoOn(page, camera, frames);
}

/** The problems that axe finds on a page, one line each. */
export async function axeFaults(page, rules = {}) {
  await page.evaluate(axeSource);
  const { violations } = await page.evaluate((options) => window.axe.run(document, { resultTypes: ['violations'], ...options }), rules);
  return violations.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.map((node) => `${node.target.join(' ')} ${node.failureSummary}`).join(', ')}`);
}

export async function accessible(page, what, rules = {}) {
  assert.deepEqual(await axeFaults(page, rules), [], `accessibility of ${what}`);
}

/** Checks both themes. They differ only in colours, so the second check is limited to these. */
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
/** Names of tests without the view's name, in order of definition. */
const repeated = [];
const byTurns = (view, place) => (name, ...rest) => {
  const test = name.replace(view, '');
  if (!repeated.includes(test)) repeated.push(test);
  if (process.env.SSLV_VIEWS === 'all' || repeated.indexOf(test) % 2 === place) it(name, ...rest);
};
/**
 * The views that tests are repeated on, each with its own `it`: ./run test alternates, running each test on one view
 * only; ./run test-long (SSLV_VIEWS=all) runs it on both. Software rendering takes most of the time, and panel_walk
 * checks all pages on both.
 */
export const views = [
  { name: 'desktop', viewport: DESKTOP, options: {}, it: byTurns('desktop', 0) },
  { name: 'phone', viewport: PHONE, options: phone, it: byTurns('phone', 1) },
];

/**
 * A slow test that adds little to the others: only ./run test-long runs it. Example: tests of only the accessibility of
 * a page, which panel_walk checks on all pages.
 */
export const itLong = process.env.SSLV_VIEWS === 'all' ? it : () => {};

/** `webgl`: with software rendering of WebGL. */
export const launch = ({ webgl = false } = {}) => chromium.launch({
  executablePath: CHROMIUM,
  timeout: PATIENCE_MS,
  chromiumSandbox: process.getuid() !== 0,
  args: [...(webgl ? ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing'] : ['--disable-gpu']), '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});

/**
 * Runs in the page: removes from the service's status all signs that this computer is too slow. On a busy computer
 * these would cause NO-GO, and their alerts would displace what is tested.
 */
function leaveOutThisComputer() {
  const SLOW = ['camera_slow', 'frames_dropped', 'latency_high', 'stage_slow'];
  function leaveOut(text) {
    const message = JSON.parse(text);
    if (message.topic !== 'status') return text;
    const { data } = message;
    const slow = data.alerts.filter(({ id }) => SLOW.includes(id));
    data.alerts = data.alerts.filter((alert) => !slow.includes(alert));
    // A check's text is the title of its most severe alert.
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

/** Runs in the page: extends request timeouts to a test's patience. Requests that fail for lack of a network still
 * fail at once. */
function bePatient(patience_ms) {
  const { timeout } = AbortSignal;
  AbortSignal.timeout = (ms) => timeout.call(AbortSignal, Math.max(ms, patience_ms));
}

/** A browser for a service's panel; limits the cameras' frame rate to `hz`. */
export function createBrowser(service, { webgl = false, hz = PICTURES_HZ } = {}) {
  const { address } = service;
  let browser;
  // The browser needs more time per image than the service, and a higher rate would test nothing more.
  for (const { source } of service.settings.cameras) source.frame_rate_hz = Math.min(source.frame_rate_hz, hz);

  /**
   * Opens a page; collects its errors, its requests to other hosts, its newest detections, and the data received with
   * its newest images.
   */
  async function openPage(viewport, options = {}) {
    // Without transitions: otherwise colours might be checked in the middle of a fade.
    const context = await browser.newContext({ viewport, colorScheme: 'dark', reducedMotion: 'reduce', ...options });
    context.setDefaultTimeout(PATIENCE_MS);
    await context.addInitScript(leaveOutThisComputer);
    await context.addInitScript(bePatient, PATIENCE_MS);
    const page = await context.newPage();
    const panel = { page, errors: [], strangers: [], detections: [], previews: [], errorsExpected: false };
    page.on('console', (message) => {
      const { url } = message.location();
      // A listed camera may belong to another test and be gone when its image is requested.
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

  /** Opens a page for a test and closes it. An error in the console or a request to another host fails the test. */
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

  async function open(prepare = () => {}) {
    browser = await launch({ webgl });
    await service.start();
    await prepare();
  }
  async function close() {
    await browser?.close();
    await service.end();
  }

  /** For a suite: opens both before its first test and closes them after its last. `prepare` runs last. */
  function aroundTests(prepare) {
    before(() => open(prepare));
    after(close);
  }

  return { aroundTests, close, open, openPage, withPage };
}
