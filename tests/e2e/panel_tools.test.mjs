// SPDX-License-Identifier: Apache-2.0
// Further tools for admins: packets as teams receive them, a kiosk, full-screen images, shortcuts, a printed report,
// graphs that are filled from the start. Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { join } from 'node:path';
import { after, before, beforeEach, describe, it } from 'node:test';
import { userInfo } from 'node:os';
import { promisify } from 'node:util';
import { accessible, accessibleInThemes, byId, comesUp, createBrowser, DESKTOP, frameNumber, itLong, live, PHONE, phone, picturesGoOn, text, textBecomes, views } from './browser.mjs';
import { textOfPdf } from './pdf.mjs';
import { detectionOf, geometryOf } from './protobuf.mjs';
import { becomes, createService, root, upgradePanel } from './service.mjs';

const GROUP = '239.255.77.91';
const CTL = process.env.SSLV_CTL ?? join(root, 'build/release/bin/ssl-visionctl');
const service = await createService(GROUP);
const { settings, address, patch } = service;
const { aroundTests, withPage } = createBrowser(service);
const get = async (path) => (await fetch(address(path))).json();

/** A team's computer: receives the group and stores its packets. */
function createTeam() {
  const packets = new Map();
  let geometry = null;
  const socket = createSocket({ type: 'udp4', reuseAddr: true });
  return {
    async join() {
      socket.on('message', (packet) => {
        const detection = detectionOf(packet);
        if (detection) packets.set(`${detection.camera_id} ${detection.frame_number}`, { detection, bytes: packet.length });
        else geometry = { ...geometryOf(packet), bytes: packet.length };
      });
      socket.bind(settings.network.vision.port, GROUP);
      await once(socket, 'listening');
      socket.addMembership(GROUP, '127.0.0.1');
    },
    packet: (camera, frame) => packets.get(`${camera} ${frame}`),
    geometry: () => geometry,
    leave: () => socket.close(),
  };
}

const number = (shown) => Number(shown.replaceAll('−', '-').replaceAll('\u2009', ''));
const near = (shown, value, by, what) => assert.ok(Math.abs(number(shown) - value) <= by + 1e-6, `${what}: ${shown} is not ${value}`);
const rows = (page) => page.$$eval(byId('packet-object'), (all) => all.map((row) => [...row.children].map((cell) => cell.textContent.trim())));

describe('tools', () => {
  aroundTests();
  beforeEach(service.restore);

  describe('packets', () => {
    let team;
    before(async () => {
      team = createTeam();
      await team.join();
    });
    after(() => team.leave());

    it('from the API equal those that a team receives', async () => {
      const heard = await becomes(() => get('api/network/packets'), ({ detections, geometry }) => detections.length === settings.cameras.length && geometry
        && detections.every(({ packets_per_s, packet }) => packets_per_s > 0 && packet.detection.robots_yellow));
      assert.deepEqual([heard.group, heard.port, heard.not_heard_because], [GROUP, settings.network.vision.port, '']);
      for (const { camera, bytes, age_s, packet } of heard.detections) {
        const received = await becomes(() => team.packet(camera, packet.detection.frame_number), Boolean, () => `packet ${packet.detection.frame_number} of camera ${camera}`);
        // JSON has the shortest digits that give the same float.
        const asFloats = (value) => JSON.parse(JSON.stringify(value), (_, one) => (typeof one === 'number' ? Math.fround(one) : one));
        assert.deepEqual(asFloats(packet.detection), asFloats(received.detection));
        assert.deepEqual([packet.detection.t_capture, packet.detection.t_sent], [received.detection.t_capture, received.detection.t_sent]);
        assert.equal(bytes, received.bytes);
        assert.ok(age_s >= 0);
      }
      const { packet: { geometry: { field, calib } }, bytes } = heard.geometry;
      assert.deepEqual({ field_length: field.field_length, field_width: field.field_width, lines: field.field_lines.length, arcs: field.field_arcs.length, cameras: calib.map(({ camera_id }) => camera_id), bytes }, team.geometry());
    });

    for (const { name, viewport, options, it } of views) {
      it(`are shown, frozen and copied (${name})`, withPage(viewport, '#/field/packets', { ...options, permissions: ['clipboard-read', 'clipboard-write'] }, async (page) => {
        const press = (what) => (options.hasTouch ? page.tap(byId(what)) : page.click(byId(what)));
        const card = byId('detection-packet');
        await page.waitForSelector(byId('packet-object'));
        await press('packets-camera-1');
        await page.waitForSelector(`${card}[data-camera="1"]`);
        await press('packets-freeze');
        await page.waitForSelector(`${byId('packets-freeze')}[aria-pressed="true"]`);
        const frame = Number(await page.getAttribute(card, 'data-frame'));
        const { detection, bytes } = await becomes(() => team.packet(1, frame), Boolean, () => `packet ${frame} of camera 1`);

        assert.equal(number(await text(page, 'packet-frame')), frame);
        assert.equal(number(await text(page, 'packet-size')), bytes);
        near(await text(page, 'packet-latency'), (detection.t_sent - detection.t_capture) * 1000, 0.5, 'latency in ms');
        const expected = [
          ...(detection.balls ?? []).map((ball) => ['Ball', ball]),
          ...(detection.robots_yellow ?? []).map((robot) => [`Yellow ${robot.robot_id}`, robot]),
          ...(detection.robots_blue ?? []).map((robot) => [`Blue ${robot.robot_id}`, robot]),
        ];
        const shown = await rows(page);
        assert.equal(shown.length, expected.length);
        expected.forEach(([what, one], i) => {
          const [object, x, y, angle, height, pixel, confidence] = shown[i];
          assert.equal(object, what);
          near(x, one.x, 0.05, `${what} x`);
          near(y, one.y, 0.05, `${what} y`);
          if (one.orientation !== undefined) near(angle, (one.orientation * 180) / Math.PI, 0.05, `${what} orientation`);
          if (one.height !== undefined) near(height, one.height, 0.05, `${what} height`);
          pixel.split(', ').forEach((side, k) => near(side, [one.pixel_x, one.pixel_y][k], 0.05, `${what} pixel`));
          near(confidence, one.confidence, 0.005, `${what} confidence`);
        });
        assert.equal(number(await text(page, 'geometry-field_lines')), team.geometry().lines);

        await comesUp(page, 'main', /Copied as JSON/, () => press('packets-copy'));
        const copied = JSON.parse(await page.evaluate(() => navigator.clipboard.readText()));
        assert.equal(copied.detection.frame_number, frame);
        assert.equal(copied.geometry.field.field_length, team.geometry().field_length);

        await press('packets-freeze');
        await page.waitForFunction(([selector, last]) => Number(document.querySelector(selector)?.dataset.frame) > last, [card, frame]);
        await accessibleInThemes(page, `packets, ${name}`);
      }));
    }

    it('tell who listens here, and that others cannot be seen', withPage(DESKTOP, '#/field/packets', {}, async (page) => {
      // The team in this test is another program on the service's computer.
      await textBecomes(page, 'local-programs', new RegExp(`socket.* of user ${userInfo().username} at port ${settings.network.vision.port}`));
      await page.waitForSelector(`${byId('listeners')} >> text=The service cannot see which teams listen.`);
      const { programs, memberships } = await get('api/network/listeners');
      assert.ok(programs.some(({ user, address: bound }) => user === userInfo().username && bound === GROUP));
      assert.ok(memberships.some(({ interface: card, joins }) => card === 'lo' && joins >= 2), JSON.stringify(memberships));
    }));

    it('say why nothing is heard while loop-back is off', withPage(DESKTOP, '#/field/packets', {}, async (page) => {
      await patch({ op: 'add', path: '/network/vision/loopback', value: false });
      await textBecomes(page, 'packets-not-heard', /loopback is off/);
      await patch({ op: 'replace', path: '/network/vision/loopback', value: true });
      await page.waitForSelector(byId('packets-not-heard'), { state: 'detached' });
    }));

    it('are printed by ssl-visionctl', async () => {
      const run = (...more) => promisify(execFile)(CTL, ['--daemon', address(''), 'packets', ...more]);
      const { stdout } = await run();
      for (const { id } of settings.cameras) assert.match(stdout, new RegExp(`camera ${id}: frame \\d+, captured`));
      assert.match(stdout, /geometry: field \d+ x \d+ mm, \d+ lines/);
      assert.match(stdout, new RegExp(`a socket of user ${userInfo().username}, bound to ${GROUP}`));
      const json = JSON.parse((await run('--json')).stdout);
      const { detection } = json.detections[0].packet;
      assert.deepEqual(Math.fround((await becomes(() => team.packet(detection.camera_id, detection.frame_number), Boolean, () => 'the packet')).detection.t_sent), Math.fround(detection.t_sent));
    });
  });

  describe('full screen', () => {
    it('shows one image, and gives the page back', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
      await page.click(byId('full-screen'));
      await page.waitForFunction((selector) => document.fullscreenElement?.matches(selector), byId('view'));
      await picturesGoOn(page, 0);
      await page.click(`${byId('view')} ${byId('full-screen')}`);
      await page.waitForFunction(() => document.fullscreenElement === null);
    }));

    it('shows a tile and the map of the overview', withPage(DESKTOP, '', {}, async (page) => {
      for (const [button, inside] of [['Camera 0 in full screen', byId('camera-picture-0')], ['Field in full screen', byId('field')]]) {
        await page.getByRole('button', { name: button }).click();
        await page.waitForFunction((selector) => document.fullscreenElement?.querySelector(selector), inside);
        await page.evaluate(() => document.exitFullscreen());
        await page.waitForFunction(() => document.fullscreenElement === null);
      }
    }));

    it('is not offered where the browser has none', withPage(DESKTOP, '', {}, async (page) => {
      await page.addInitScript(() => Object.defineProperty(document, 'fullscreenEnabled', { value: false }));
      await page.reload();
      await live(page);
      await picturesGoOn(page, 0);
      assert.equal(await page.locator(byId('full-screen')).count(), 0);
    }));
  });

  describe('kiosk', () => {
    for (const { name, viewport, options, it } of views) {
      it(`shows cameras, field and verdict, and changes nothing (${name})`, withPage(viewport, '#/kiosk', options, async (page) => {
        for (const { id } of settings.cameras) await picturesGoOn(page, id);
        await page.waitForSelector(byId('field-robot'));
        // The demo has no real camera: its GO must not be mistaken for the field's.
        await textBecomes(page, 'verdict', /^GO · simulated$/);
        assert.deepEqual(await page.$$eval('input, select, textarea', (all) => all.length), 0);
        assert.deepEqual(await page.$$eval('nav', (all) => all.length), 0);
        const mayStayAwake = await page.evaluate(() => navigator.wakeLock?.request('screen').then((lock) => lock.release().then(() => true), () => false));
        await page.waitForSelector(`${byId('kiosk')}[data-awake="${mayStayAwake}"]`);
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true, 'nothing is cut at the side');
        await accessible(page, `kiosk, ${name}`);
      }));
    }

    it('says which keys it has, in full screen, too', withPage(DESKTOP, '#/kiosk', {}, async (page) => {
      const dialog = page.locator(byId('shortcuts-dialog'));
      await page.waitForSelector(byId('kiosk'));
      for (const isFull of [false, true]) {
        if (isFull) await page.click(byId('full-screen'));
        await page.waitForFunction((full) => (document.fullscreenElement !== null) === full, isFull);
        await page.keyboard.press('?');
        await dialog.waitFor();
        assert.deepEqual(await page.$$eval(byId('shortcut'), (all) => all.map((one) => one.textContent)), ['?Show this list of shortcuts', 'EscLeave the kiosk']);
        await page.click(`${byId('shortcuts-dialog')} [aria-label="Close"]`);
        await dialog.waitFor({ state: 'hidden' });
      }
      await page.evaluate(() => document.exitFullscreen());
      // Escape first closes an open dialog.
      await page.keyboard.press('?');
      await dialog.waitFor();
      await page.keyboard.press('Escape');
      await dialog.waitFor({ state: 'hidden' });
      assert.match(page.url(), /#\/kiosk$/);
      await page.keyboard.press('Escape');
      await page.waitForURL(/#\/overview$/);
      await page.waitForSelector(byId('camera-tile-0'));
    }));

    it('works for those who may only look', async () => {
      const answer = await fetch(address('api/passwords/admin'), { method: 'PUT', body: JSON.stringify({ password: 'only for admins' }) });
      assert.ok(answer.ok, await answer.text());
      try {
        await withPage(DESKTOP, '#/kiosk', {}, async (page) => {
          assert.equal((await page.evaluate(() => fetch('api/session').then((answer) => answer.json()))).may, 'look');
          for (const { id } of settings.cameras) await picturesGoOn(page, id);
        })();
      } finally {
        await service.stop();
        await service.forget();
        await service.start();
      }
    });

    it('comes back with the service, and loads itself again after an upgrade', withPage(DESKTOP, '#/kiosk', {}, async (page, panel) => {
      panel.errorsExpected = true; // the connection is lost
      await picturesGoOn(page, 0);
      await page.evaluate(() => { window.before = true; });
      await service.stop();
      await page.waitForSelector(`${byId('connection')}[data-state="stale"]`, { state: 'attached' });
      await service.start();
      await live(page);
      await picturesGoOn(page, 0);
      assert.equal(await page.evaluate(() => window.before), true, 'the same panel is not loaded again');

      await service.stop();
      const { panelFolder: old } = service;
      service.panelFolder = join(service.folder, 'newer-panel');
      upgradePanel(old, service.panelFolder);
      try {
        await service.start();
        await page.waitForFunction(() => window.before === undefined);
        await live(page);
        await picturesGoOn(page, 0);
        assert.match(page.url(), /#\/kiosk$/);
      } finally {
        await service.stop();
        service.panelFolder = old;
      }
    }));
  });

  describe('shortcuts', () => {
    it('are listed by the key ?, and each that is listed works', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
      await page.waitForSelector(byId('overlay-robot'), { state: 'attached' });
      await page.keyboard.press('?');
      const dialog = page.locator(byId('shortcuts-dialog'));
      await dialog.waitFor();
      const listed = await page.$$eval(byId('shortcut'), (all) => all.map((one) => [one.querySelector('dd').textContent, [...one.querySelectorAll('kbd')].map((key) => key.textContent)]));
      const keysOf = Object.fromEntries(listed);
      assert.deepEqual(keysOf['Hide or show all layers'], ['H']);
      assert.deepEqual(keysOf['Show or hide: Detections'], ['1']);
      assert.deepEqual(keysOf['Show this list of shortcuts'], ['?']);
      // Every button with a shortcut is listed with that key.
      const named = await page.$$eval('main [aria-keyshortcuts], nav [aria-keyshortcuts]', (all) => all.map((one) => one.getAttribute('aria-keyshortcuts')));
      const all = Object.values(keysOf).flat();
      for (const key of named) assert.ok(all.includes(key.replace('Control', 'Ctrl').replaceAll('+', ' ')), `${key} is not listed`);
      await accessible(page, 'shortcuts');

      // Elements behind the dialog do not react to keys.
      await page.keyboard.press('h');
      await page.keyboard.press('Escape');
      await dialog.waitFor({ state: 'hidden' });
      await page.waitForSelector(byId('overlay-robot'));
      await page.keyboard.press(keysOf['Show or hide: Detections'][0]);
      await page.waitForSelector(byId('overlay-robot'), { state: 'detached' });
      await page.keyboard.press(keysOf['Show or hide: Detections'][0]);
      await page.waitForSelector(byId('overlay-robot'), { state: 'attached' });
      const before = await frameNumber(page, 0);
      assert.ok(before > 0);
      await page.keyboard.press(keysOf['Freeze or unfreeze the image'][0].toLowerCase());
      await page.waitForSelector(`${byId('freeze')}[aria-pressed="true"]`);
    }));

    it('are inactive while typing, and listed by a button', withPage(DESKTOP, '#/settings', {}, async (page) => {
      const search = page.locator('input[type="search"]').first();
      await search.waitFor();
      await page.keyboard.press('/');
      await page.waitForFunction(() => document.activeElement?.matches('input[type="search"]'));
      await page.keyboard.type('a?/');
      assert.equal(await search.inputValue(), 'a?/');
      assert.equal(await page.locator(byId('shortcuts-dialog')).isVisible(), false);
      await page.click(byId('open-shortcuts'));
      await page.waitForSelector(byId('shortcuts-dialog'));
      const listed = await page.$$eval(`${byId('shortcut')} dd`, (all) => all.map((one) => one.textContent));
      assert.ok(listed.includes('Search') && listed.includes('Undo your last change'), listed.join(', '));
    }));

    it('of the other pages are those of the page that is open', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
      await page.waitForSelector(byId('tool-paint'));
      await page.keyboard.press('?');
      const texts = () => page.$$eval(`${byId('shortcut')} dd`, (all) => all.map((one) => one.textContent));
      assert.ok((await texts()).includes('Tool: Paint'));
      await page.keyboard.press('Escape');
      await page.keyboard.press('p');
      await page.waitForSelector(`${byId('tool-paint')}[aria-pressed="true"]`);
      await page.evaluate(() => { location.hash = '#/diagnostics'; });
      await page.waitForSelector(byId('graphs'));
      await page.keyboard.press('?');
      assert.ok(!(await texts()).includes('Tool: Paint'));
      assert.ok((await texts()).includes('Cursor to the newest second'));
    }));

    it('have no button on a phone', withPage(PHONE, '', phone, async (page) => {
      assert.equal(await page.locator(byId('open-shortcuts')).isVisible(), false);
    }));
  });

  describe('calibration report', () => {
    const post = async (path, body) => {
      const answer = await fetch(address(path), { method: 'POST', body: JSON.stringify(body) });
      assert.ok(answer.ok, await answer.text());
    };

    it('has the figures of the calibration in use, on paper too', withPage(DESKTOP, '#/calibration/0', {}, async (page) => {
      await post('api/cameras/0/calibration', {});
      const { report } = await becomes(() => get('api/cameras/0/calibration'), ({ state }) => state === 'done' || state === 'failed');
      assert.ok(report?.found);
      await post('api/cameras/0/calibration/accept', { force: true });

      await page.evaluate(() => { location.hash = '#/calibration/0/report'; });
      await page.waitForSelector(`${byId('report-0')}[data-ready="true"]`);
      await page.waitForFunction((selector) => document.querySelector(selector)?.naturalWidth > 0, byId('report-picture'));
      await page.waitForSelector(byId('overlay-lines'), { state: 'attached' });
      assert.match(await text(page, 'report-made'), /^Made \d{4}-\d\d-\d\d \d\d:\d\d:\d\d by .+\.$/);
      const figures = await text(page, 'report-figures');
      const { history } = await get('api/cameras/0/calibration');
      const digits = (value) => value.toFixed(value >= 99.5 ? 0 : value >= 9.95 ? 1 : value >= 0.0995 ? 2 : 3);
      assert.ok(figures.includes(`${digits(history[0].figures.expected_on_floor_mm)} mm`), figures);
      assert.ok(figures.includes(`${digits(history[0].figures.rms_px)} px`), figures);
      assert.equal(await page.locator(`${byId('report-lines')} tbody tr`).count(), report.lines.length);
      assert.equal(await page.locator(`${byId('report-history')} tbody tr`).count(), history.length);
      await accessibleInThemes(page, 'calibration report');

      // The button prints the page.
      await page.evaluate(() => { window.print = () => { window.printed = true; }; });
      await page.click(byId('print'));
      assert.equal(await page.evaluate(() => window.printed), true);
      await page.emulateMedia({ media: 'print' });
      for (const hidden of [byId('print'), 'nav[aria-label="Pages"]', byId('theme')]) assert.equal(await page.locator(hidden).first().isVisible(), false, hidden);
      const paper = textOfPdf(await page.pdf({ format: 'A4' }));
      const { version } = await get('api/status');
      for (const words of ['Calibration report', settings.site, `ssl-visiond ${version}`, 'Camera 0', 'Expected error on the floor', 'Focal length', 'Halfway line', 'History']) {
        assert.ok(paper.includes(words.replace(/\s/g, '')), `"${words}" is not in the PDF: ${paper.slice(0, 600)}`);
      }
    }));

    it('is one for all cameras, and says what is not known', withPage(PHONE, '#/calibration/all/report', phone, async (page) => {
      for (const { id } of settings.cameras) await page.waitForSelector(`${byId(`report-${id}`)}[data-ready="true"]`);
      await page.waitForSelector(`${byId('report-1')} >> text=was not made with this service`);
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true, 'nothing is cut at the side');
      await accessible(page, 'calibration report, phone');
    }));

    it('is found from the history of a calibration', withPage(DESKTOP, '#/calibration/0', {}, async (page) => {
      await page.getByRole('button', { name: /In use/ }).first().click();
      await page.click(byId('to-report'));
      await page.waitForSelector(byId('report-0'));
    }));
  });

  describe('graphs', () => {
    /** Age in s of the oldest point of a graph of the last minute. */
    const oldest = (page, selector) => page.waitForFunction((path) => {
      const line = document.querySelector(path);
      const x = Number(/^M([\d.]+)/.exec(line?.getAttribute('d') ?? '')?.[1] ?? NaN);
      const axis = line?.ownerSVGElement?.querySelector('path')?.getAttribute('d') ?? '';
      const width = Number(/H([\d.]+)/.exec(axis)?.[1]);
      const age_s = 60 * (1 - x / width);
      // This point is older than the page itself, so it cannot be from the live connection.
      return age_s > performance.now() / 1000 + 2 ? age_s : null;
    }, selector);

    before(async () => {
      await becomes(() => get('api/timeline?seconds=60'), ({ time_s, cameras }) => time_s.length > 15 && cameras[0].latency_p50_ms.filter(Number.isFinite).length > 15);
    });

    for (const [what, path, selector] of [['Camera page', '#/camera/0', 'svg .line50'], ['overview', '', `${byId('camera-tile-0')} svg .line50`]]) {
      it(`of the ${what} are full at once`, withPage(DESKTOP, path, {}, async (page) => {
        await oldest(page, selector);
      }));
    }

    itLong('have no hole after a lost connection', withPage(DESKTOP, '#/camera/0', {}, async (page, panel) => {
      panel.errorsExpected = true; // the connection is refused
      const open = new Set();
      let isBlocked = false;
      await page.routeWebSocket(/api\/ws/, (socket) => {
        if (isBlocked) { void socket.close({ code: 1001 }); return; }
        socket.connectToServer();
        open.add(socket);
      });
      await page.reload();
      await live(page);
      await oldest(page, 'svg .line50');
      isBlocked = true;
      for (const socket of open) await socket.close({ code: 1001 });
      await page.waitForSelector(`${byId('connection')}[data-state="stale"]`, { state: 'attached' });
      const gone = await get('api/timeline?seconds=1');
      await becomes(() => get('api/timeline?seconds=1'), ({ time_s }) => time_s[0] > gone.time_s[0] + 5);
      isBlocked = false;
      await live(page);
      await page.waitForFunction(() => /^M[^M]+$/.test(document.querySelector('svg .line50')?.getAttribute('d') ?? ''));
    }));
  });
});
