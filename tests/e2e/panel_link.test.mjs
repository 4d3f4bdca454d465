// SPDX-License-Identifier: Apache-2.0
// The panel over slow or broken links, and its alerts when nobody watches it. A proxy connects the real service and the
// browser.
import assert from 'node:assert/strict';
import { copyFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, beforeEach, describe, it } from 'node:test';
import { accessible, byId, createBrowser, DESKTOP, itLong, live, PHONE, phone, picturesGoOn, textBecomes, views } from './browser.mjs';
import { layoutFaults } from './layout.mjs';
import { becomes, createService, root, upgradePanel } from './service.mjs';
import { createLink } from './slow_link.mjs';

const service = await createService('239.255.77.91');
const link = await createLink(() => service.settings.panel.port);
const browser = createBrowser({ ...service, address: link.address });

const linkIs = (page, state) => page.waitForSelector(`${byId('connection')}[data-link="${state}"]`);
/** All image problems shown on the page. */
const troubles = (page) => page.locator(byId('picture-trouble')).allTextContents();

/** A camera's image file, which does not exist at first. */
const picture = join(service.folder, 'camera.jpg');
const noFiles = (camera = 1, path = picture) => service.patch({ op: 'replace', path: `/cameras/${camera}/source`, value: { backend: 'files', path, loop: true, frame_rate_hz: 20 } });
/** The event history, which is updated once a second. */
const events = async () => (await (await fetch(service.address('api/events'))).json()).entries;
const isLost = () => service.statusBecomes(({ cameras }) => cameras[1].state === 'lost');

/** Opens a page whose errors are expected: the browser logs what cannot be loaded. */
async function onPage(path, test, { viewport = DESKTOP, options = {}, prepare = () => {} } = {}) {
  const { page, strangers } = await browser.openPage(viewport, options);
  try {
    await prepare(page);
    await page.goto(link.address(path));
    await test(page);
    assert.deepEqual(strangers, [], 'requests to other hosts');
  } finally {
    await page.context().close();
  }
}

/** Waits until the service worker controls the page and has its files. */
const kept = (page) => page.waitForFunction(() => navigator.serviceWorker?.controller !== null && navigator.serviceWorker !== undefined);

// Otherwise this process would not end.
after(() => link.end());

describe('panel over a bad link', () => {
  browser.aroundTests(() => {});
  beforeEach(async () => {
    link.mend();
    link.limit(Infinity);
    await service.restore();
  });
  afterEach(() => link.limit(Infinity));

  for (const kbps of process.env.SSLV_VIEWS === 'all' ? [1000, 200] : [200]) {
    it(`says "Slow link" at ${kbps} kbit/s and reports only really lost cameras`, () => onPage('', async (page) => {
      await linkIs(page, 'slow');
      await textBecomes(page, 'connection', /^Slow link$/);
      // Checks repeatedly until two seconds' worth of data has been transferred.
      const before = link.bytes();
      await becomes(async () => {
        const said = await troubles(page);
        assert.ok(said.every((text) => /^(Slow link|Waiting|No data)/.test(text)), `no camera is blamed: ${said}`);
        assert.equal(await page.locator('.tile.bad').count(), 0);
        return link.bytes() - before;
      }, (bytes) => bytes > 2 * kbps * 1000 / 8);
      await noFiles();
      await page.waitForFunction((selector) => document.querySelector(selector)?.textContent.includes('Camera lost'), `${byId('camera-tile-1')} ${byId('picture-trouble')}`);
    }, { prepare: () => link.limit(kbps) }));
  }

  it('shows the tracks at 1000 kbit/s, and never blames the service', browser.withPage(DESKTOP, '#/field/live', {}, async (page) => {
    await page.waitForSelector(byId('live-field'));
    link.limit(1000);
    const before = link.bytes();
    await becomes(async () => {
      const texts = await page.locator(byId('live-missing')).allTextContents();
      assert.ok(texts.every((text) => !/tracked/.test(text)), texts.join());
      return link.bytes() - before;
    }, (bytes) => bytes > 250_000);
    await page.waitForFunction((selector) => document.querySelector(selector)?.getAttribute('aria-label')?.includes('robot'), byId('live-field'));
  }));

  itLong('says "Slow link" beside the verdict on other pages, on a phone, too', browser.withPage(PHONE, '#/camera/0', phone, async (page) => {
    await picturesGoOn(page, 0, 1);
    link.limit(200);
    await textBecomes(page, 'connection', /GO\s*simulated.*Slow link$/);
    await accessible(page, 'a slow link');
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `the page is ${wide} px too wide`);
  }));

  for (const hasWorker of [false, true]) {
    it(`opens a page by itself when the link is back, ${hasWorker ? 'and at once where the browser keeps files' : 'in a browser that keeps no files'}`, () => onPage('', async (page) => {
      await live(page);
      if (hasWorker) await kept(page);
      link.cut();
      await page.evaluate(() => { location.hash = '#/diagnostics'; });
      if (hasWorker) {
        await page.waitForSelector('h1:has-text("Diagnostics")', { state: 'attached' });
      } else {
        await page.waitForSelector(`${byId('page-loading')}:has-text("opens automatically when the connection is back")`);
      }
      link.mend();
      await page.waitForSelector('h1:has-text("Diagnostics")', { state: 'attached' });
      await live(page);
      // Including its styles.
      await page.waitForFunction(() => {
        try {
          return [...document.querySelectorAll('link[rel="stylesheet"]')].some(({ href, sheet }) => href.includes('DiagnosticsPage') && sheet?.cssRules.length > 0);
        } catch {
          return false; // failed to load
        }
      });
    }, { options: { serviceWorkers: hasWorker ? 'allow' : 'block' } }));
  }

  it('opens from what the browser keeps, says that the service is out of reach, and goes on when it is back', () => onPage('', async (page) => {
    await live(page);
    await kept(page);
    link.cut();
    await page.reload();
    await page.waitForSelector('text=The service cannot be reached. The panel tries again automatically.');
    for (const hash of ['camera/0', 'colours', 'calibration', 'settings', 'field', 'diagnostics', 'api']) {
      await page.evaluate((to) => { location.hash = `#/${to}`; }, hash);
      await page.waitForFunction(() => !document.querySelector('[data-testid="page-loading"]') && document.querySelector('main h1, main .card'));
    }
    const names = await page.evaluate(async () => (await Promise.all((await caches.keys()).map(async (name) => (await (await caches.open(name)).keys()).map(({ url }) => new URL(url).pathname)))).flat());
    assert.ok(names.includes('/') && names.some((name) => name.startsWith('/assets/cubeView')), `all is kept: ${names}`);
    assert.deepEqual(names.filter((name) => name.startsWith('/api')), [], 'nothing of the interface is kept');
    link.mend();
    await live(page);
  }));

  for (const [what, prepare] of [
    ['has no room for files', () => { CacheStorage.prototype.open = () => Promise.reject(new DOMException('full', 'QuotaExceededError')); }],
    ['knows no service workers', () => { Object.defineProperty(Navigator.prototype, 'serviceWorker', { get: () => undefined }); }],
    ['has a clock that is days behind', () => { const now = Date.now; Date.now = () => now() - 3 * 86_400_000; }],
    ['keeps nothing', () => { for (const name of ['localStorage', 'sessionStorage']) Object.defineProperty(window, name, { get() { throw new DOMException('denied', 'SecurityError'); } }); }],
  ]) {
    it(`works in a browser that ${what}`, () => onPage('', async (page) => {
      await live(page);
      await picturesGoOn(page, 0);
      await page.click('nav a:has-text("Camera")');
      await picturesGoOn(page, 0);
    }, { prepare: (page) => page.addInitScript(prepare) }));
  }

  /** Runs `work` while the service serves another version of the panel. */
  async function withUpgrade(work) {
    const built = service.panelFolder;
    const upgraded = join(service.folder, 'upgraded');
    upgradePanel(built, upgraded);
    await service.stop();
    service.panelFolder = upgraded;
    try {
      await service.start();
      await work();
    } finally {
      await service.stop();
      service.panelFolder = built;
      rmSync(upgraded, { recursive: true });
    }
  }
  const isUpgraded = (page) => page.waitForSelector('script[src$="index-upgraded.js"]', { state: 'attached' });

  for (const hasWorker of [false, true]) {
    (hasWorker ? it : itLong)(`takes the panel of an upgraded service by itself, in a browser that keeps ${hasWorker ? 'files' : 'none'}`, () => onPage('', async (page) => {
      await live(page);
      if (hasWorker) await kept(page);
      await withUpgrade(async () => {
        await isUpgraded(page);
        await live(page);
        await page.click('nav a:has-text("Diagnostics")');
        await page.waitForSelector('h1:has-text("Diagnostics")', { state: 'attached' });
      });
    }, { options: { serviceWorkers: hasWorker ? 'allow' : 'block' } }));
  }

  it('opens a page whose files went with an upgrade, even where a reload did not help before', () => onPage('#/settings', async (page) => {
    await live(page);
    await kept(page);
    await withUpgrade(async () => {
      await page.waitForSelector(byId('new-panel'));
      const hasRoom = async () => {
        const faults = await layoutFaults(page, { isTouch: true });
        assert.deepEqual(faults.filter(({ at }) => /new-panel|connection|theme/.test(at)), [], 'the bar has room for it');
      };
      await hasRoom();
      link.limit(60);
      await linkIs(page, 'slow');
      await hasRoom();
      link.limit(Infinity);
      // The browser's own cache may still have the file.
      await page.route(/DiagnosticsPage-[\w-]*(?<!-upgraded)\.js$/, (route) => route.fulfill({ status: 404 }));
      await page.evaluate(async () => {
        sessionStorage.setItem('reloaded-for', 'assets/index-upgraded.js');
        const taken = new Promise((resolve) => { navigator.serviceWorker.addEventListener('controllerchange', resolve); });
        await (await navigator.serviceWorker.getRegistration()).update();
        await taken;
        location.hash = '#/diagnostics';
      });
      await isUpgraded(page);
      await page.waitForSelector('h1:has-text("Diagnostics")', { state: 'attached' });
    });
  }, { viewport: PHONE, options: phone }));

  it('is at most 120 kB on its way to the Camera page', () => onPage('#/camera/0', async (page) => {
    await picturesGoOn(page, 0, 1);
    const files = await page.evaluate(() => [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')]
      .filter(({ name }) => !new URL(name).pathname.startsWith('/api/') && /\/$|\.(js|css|html|woff2?)$/.test(new URL(name).pathname))
      .map(({ name, encodedBodySize }) => ({ name: new URL(name).pathname, bytes: encodedBodySize })));
    const bytes = files.reduce((sum, file) => sum + file.bytes, 0);
    assert.ok(files.length >= 5 && files.every((file) => file.bytes > 0), JSON.stringify(files));
    assert.ok(bytes <= 120_000, `${bytes} bytes: ${JSON.stringify(files)}`);
  }, { options: { serviceWorkers: 'block' } }));
});

describe('panel that nobody looks at', () => {
  browser.aroundTests(() => {});
  beforeEach(async () => {
    link.mend();
    link.limit(Infinity);
    await service.restore();
    rmSync(picture, { force: true });
  });

  const sign = (page) => page.evaluate(() => decodeURIComponent(document.querySelector('link[rel="icon"]').href));

  /** Counts tones and notifications instead of playing or showing them. */
  const listen = (page) => page.addInitScript(() => {
    window.heard = { tones: 0, notes: [] };
    const start = OscillatorNode.prototype.start;
    OscillatorNode.prototype.start = function count(...when) { window.heard.tones++; return start.apply(this, when); };
    const shown = new Set();
    window.Notification = class {
      constructor(title, { body, tag, renotify }) {
        // As in a browser: a notification silently replaces one with the same tag, unless `renotify` is set.
        if (!tag || !shown.has(tag) || renotify) window.heard.notes.push(`${title}: ${body}`);
        shown.add(tag);
      }
      close() {}
    };
    window.Notification.permission = 'default';
    window.Notification.requestPermission = async () => { window.Notification.permission = 'granted'; return 'granted'; };
    window.leave = () => { Object.defineProperty(document, 'visibilityState', { get: () => 'hidden' }); };
  });

  for (const { name, viewport, options, it } of views) {
    it(`tells a lost camera in title and sign, by sound and notification, and reopens it, on a ${name}`, () => onPage('', async (page) => {
      const click = (selector) => (options.hasTouch ? page.tap(selector) : page.click(selector));
      await live(page);
      if (options.hasTouch) {
        await click('button[aria-controls="more-pages"]');
        await click(byId('away-more'));
      } else {
        await click(byId('away'));
      }
      await page.waitForSelector(`${byId('away-dialog')} h2`);
      await click(byId('away-sound'));
      await click(byId('away-notification'));
      await page.waitForFunction((selector) => document.querySelector(selector).checked, byId('away-notification'));
      await accessible(page, `alerts away from the page on a ${name}`);
      await click(byId('away-close'));
      await page.reload();
      await live(page);
      await page.mouse.click(2, 2); // pages are silent before the first click
      await page.evaluate(() => { window.leave(); window.Notification.permission = 'granted'; });

      await noFiles();
      await isLost();
      await page.waitForFunction((site) => document.title === `NO-GO · Camera 1 lost · ${site}`, service.settings.site);
      assert.match(await sign(page), /#c8102e/, 'the sign is red');
      await page.waitForFunction(() => window.heard.tones === 2 && window.heard.notes.length === 1);
      assert.deepEqual(await page.evaluate(() => window.heard.notes), [`${service.settings.site}: Camera 1 lost`]);

      const [tile, button] = await Promise.all([byId('camera-tile-1'), byId('reopen-1')].map((selector) => page.locator(selector).boundingBox()));
      assert.ok(button.x >= tile.x && button.x + button.width <= tile.x + tile.width, `in its tile: ${JSON.stringify({ tile, button })}`);
      // Before the files exist again: otherwise the service may reopen it first.
      await click(byId('reopen-1'));
      await becomes(events, (entries) => entries.some(({ title }) => title === 'Asked to reopen camera 1'));
      copyFileSync(join(root, 'tests/golden/division_b.jpg'), picture);
      await service.statusBecomes(({ cameras }) => cameras[1].state === 'running');
      await page.waitForSelector(byId('reopen-1'), { state: 'detached' });

      // The next lost camera is announced too, as is the same one when it is lost again.
      await noFiles(1, join(service.folder, 'none.jpg'));
      await page.waitForFunction(() => window.heard.notes.length >= 2 && window.heard.tones === 2 * window.heard.notes.length);
      const before = await page.evaluate(() => window.heard.notes.length);
      await noFiles(0, join(service.folder, 'none.jpg'));
      // Alerts about the lost robots may come first, and both cameras may be announced together.
      await page.waitForFunction((from) => window.heard.notes.slice(from).some((note) => /Cameras? 0\b.* lost$/.test(note)), before);
      assert.equal((await page.evaluate(() => window.heard.notes))[0], `${service.settings.site}: Camera 1 lost`);
    }, { viewport, options: { ...options, serviceWorkers: 'block' }, prepare: listen }));
  }

  it('drops sounds while the browser does not allow them', () => onPage('', async (page) => {
    await live(page);
    await page.evaluate(() => { window.leave(); });
    await noFiles();
    await isLost();
    await page.waitForFunction(() => window.heard.notes.length === 1);
    await page.clock.fastForward(1000); // the page no longer waits for permission to play
    await page.mouse.click(2, 2);
    // The next alert plays its two tones; none of the first alert are played.
    await noFiles(0);
    await page.waitForFunction(() => window.heard.notes.length === 2 && window.heard.tones >= 2);
    assert.deepEqual(await page.evaluate(() => window.heard), { tones: 2, notes: [1, 0].map((id) => `${service.settings.site}: Camera ${id} lost`) });
  }, {
    options: { serviceWorkers: 'block' },
    async prepare(page) {
      await page.clock.install();
      await listen(page);
      await page.addInitScript(() => {
        // A headless browser lets every page play sound; others only after the first click.
        let mayStart = () => {};
        const isAllowed = new Promise((resolve) => { mayStart = resolve; });
        let state = 'suspended';
        Object.defineProperty(AudioContext.prototype, 'state', { get: () => state });
        AudioContext.prototype.resume = () => isAllowed;
        addEventListener('pointerdown', () => { state = 'running'; mayStart(); }, { capture: true });
        window.Notification.permission = 'granted';
        for (const way of ['sound', 'notification']) localStorage.setItem(`away-${way}`, 'on');
      });
    },
  }));

  for (const { name, viewport, options, it } of views) it(`offers to reopen on the Camera page of a ${name}, and says what came of it`, () => onPage('#/camera/1', async (page) => {
    await live(page);
    await noFiles();
    await isLost();
    await page.click(byId('reopen-1'));
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `the page is ${wide} px too wide`);
    await becomes(events, (entries) => entries.some(({ id }) => id === 'camera_reopen_asked'));
    await page.waitForSelector(`${byId('picture-trouble')}:has-text("Still lost")`);
  }, { viewport, options }));

  it('says plainly when the browser allows no notifications', () => onPage('', async (page) => {
    await live(page);
    await page.click(byId('away'));
    await textBecomes(page, 'away-problem', /only over HTTPS/);
    assert.ok(await page.isDisabled(byId('away-notification')));
  }, { prepare: (page) => page.addInitScript(() => { Object.defineProperty(window, 'isSecureContext', { get: () => false }); }) }));
});
