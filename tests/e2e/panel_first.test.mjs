// SPDX-License-Identifier: Apache-2.0
// From a fresh installation to a field: the panel of a service without cameras, in a real browser.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, symlinkSync } from 'node:fs';
import { createRequire } from 'node:module';
import { networkInterfaces } from 'node:os';
import { join } from 'node:path';
import { beforeEach, describe, it } from 'node:test';
import { accessible, accessibleInThemes, byId, createBrowser, DESKTOP, PHONE, phone, picturesGoOn, textBecomes, views } from './browser.mjs';
import { becomes, createService, root } from './service.mjs';

const service = await createService('239.255.77.86');
const { address, settings } = service;
settings.cameras = [];
const { aroundTests, withPage } = createBrowser(service);

const require = createRequire(join(root, 'webui/package.json'));
const readerSource = readFileSync(require.resolve('jsqr/dist/jsQR.js'), 'utf8');
const golden = join(root, 'tests/golden');
const photo = join(golden, 'division_b.jpg');

const cameras = async () => (await (await fetch(address('api/settings'))).json()).settings.cameras;
const stepBecomes = (page, id, state) => page.waitForSelector(`${byId(`step-${id}`)}[data-state="${state}"]`, { state: 'attached' });

/** Checks that no content is wider than the window. */
const fits = async (page) => {
  const [wide, window] = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.clientWidth]);
  assert.ok(wide <= window, `${wide} px wide in ${window}`);
};

/** Decodes the QR code on the screen, as a phone's camera would. */
async function readCode(page) {
  const code = page.locator(byId('qr'));
  await code.waitFor();
  const shot = (await code.screenshot({ type: 'png' })).toString('base64');
  await page.evaluate(readerSource);
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    return window.jsQR(data, bitmap.width, bitmap.height)?.data ?? null;
  }, shot);
}

describe('the first set-up', () => {
  aroundTests();
  beforeEach(service.restore);

  for (const { name, viewport, options, it } of views) {
    it(`begins with adding a camera and the steps to GO, on a ${name}`, withPage(viewport, '', options, async (page) => {
      await page.waitForSelector(byId('add-camera'));
      await textBecomes(page, 'verdict', /NO-GO/);
      for (const id of ['camera', 'network', 'field', 'colours', 'calibration', 'robots', 'password']) {
        const step = await page.waitForSelector(`${byId(`step-${id}`)}[data-state="todo"]`);
        assert.equal(await step.$$eval('.btn', (all) => all.length), 1, `${id} has one action`);
      }
      await textBecomes(page, 'steps-done', /^0 of 7 done$/);

      // The camera pages lead to adding a camera.
      for (const name of ['camera', 'colours', 'calibration']) {
        await page.goto(address(`#/${name}`));
        await page.click('main a:has-text("Add a camera")');
        await page.waitForSelector(byId('add-camera'));
      }
      const [steps, add] = await Promise.all([byId('first-steps'), byId('add-camera')].map((one) => page.locator(one).boundingBox()));
      assert.ok(steps.height > 150 && steps.y + steps.height <= add.y, 'the steps have their own room');
      // The search for cameras ran automatically and has a result, whatever is plugged in.
      await page.waitForSelector(`${byId('none-found')}, ${byId('found-camera')}`);
      for (const way of ['address', 'files', 'upload']) {
        await page.click(byId(`way-${way}`));
        await page.waitForSelector(`${byId(`way-${way}`)}[aria-expanded="true"]`);
        await fits(page);
      }
      await accessibleInThemes(page, `the first set-up on a ${name}`);
    }));
  }

  it('shows an image of a camera that is found, before it is added', withPage(DESKTOP, '#/settings/cameras', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs the missing camera
    // Cameras plugged into this computer are unknown, so the list is faked; everything else is real.
    const source = { backend: 'files', path: photo, loop: true };
    await page.route('**/api/sources', async (route) => route.fulfill({ json: { sources: [
      { backend: 'files', name: 'Photo', model: 'Photo', serial: '17', formats: [], source, camera: (await cameras()).length ? 0 : null },
      { backend: 'files', name: 'Broken', model: 'Broken', serial: '', formats: [], source: { backend: 'files', path: join(golden, 'none') }, camera: null },
    ] } }));
    await page.click(byId('find-cameras'));
    const [good, bad] = await Promise.all([0, 1].map(async (i) => {
      const found = page.locator(byId('found-camera')).nth(i);
      await found.locator(`${byId('source-image')}:is([data-state="image"], [data-state="failed"])`).waitFor();
      return found;
    }));
    const size = await good.locator('img').evaluate(async (image) => { await image.decode(); return image.naturalWidth; });
    assert.equal(size, 320);
    assert.match(await bad.locator('.problem').textContent(), /No such file/i);
    await good.locator('button:has-text("Add")').click();
    await becomes(cameras, (list) => list.length === 1 && list[0].source.path === photo);
    await page.waitForSelector(byId('camera-entry'));
    // A second click would add the same camera twice.
    const again = page.locator(byId('found-camera')).first();
    await again.locator('text=in use: camera 0').waitFor();
    assert.equal(await again.locator('button:has-text("Add")').count(), 0);
  }));

  it('adds a GigE camera by its address', withPage(DESKTOP, '', {}, async (page) => {
    await page.click(byId('way-address'));
    await page.fill(byId('camera-address'), '192.0.2.300');
    assert.ok(await page.isDisabled(byId('add-address')), 'no address');
    await page.fill(byId('camera-address'), '127.0.0.9');
    await page.click(byId('add-address'));
    const [camera] = await becomes(cameras, (list) => list.length === 1);
    assert.equal(camera.source.backend, 'aravis');
    assert.equal(camera.source.camera, '127.0.0.9');
    await page.waitForSelector(byId('camera-tile-0'));
    // It is a real camera, but it does not run.
    await page.click(byId('steps-all'));
    await stepBecomes(page, 'camera', 'trouble');
  }));

  it('adds a folder of images, and says that they are recorded', withPage(DESKTOP, '', {}, async (page) => {
    await page.click(byId('way-files'));
    await page.click(`${byId('file-entry')} button:text-is("${join(root, 'tests')}")`);
    await page.click(`${byId('file-entry')} button:text-is("golden")`);
    await textBecomes(page, 'folder', /golden$/);
    assert.match(await page.textContent(byId('add-folder')), /Add this folder \(1 image\)/);
    assert.deepEqual(await page.$$eval(byId('file-entry'), (all) => all.map((one) => one.textContent.trim())), ['division_b.jpgAdd', 'parts.clipAdd', 'small.clipAdd'], 'nothing but images, clips and folders');
    await page.click(byId('add-folder'));
    await page.waitForSelector(byId('camera-tile-0'));
    await picturesGoOn(page, 0);
    assert.equal(await page.textContent(byId('origin-0')), 'recorded');
    await textBecomes(page, 'verdict-unreal', /recorded images only/);
    await page.click(byId('steps-all'));
    await stepBecomes(page, 'camera', 'todo');
    await textBecomes(page, 'step-camera', /A real camera is missing/);
    const [{ source }] = await cameras();
    assert.deepEqual([source.backend, source.path, source.loop], ['files', golden, true]);
  }));

  it('does not leave the folders that settings may name', withPage(DESKTOP, '', {}, async (page, panel) => {
    const outside = join(service.stateFolder, 'trap');
    mkdirSync(outside, { recursive: true });
    symlinkSync('/etc', join(outside, 'etc'));
    mkdirSync(join(outside, 'inside'));
    await page.click(byId('way-files'));
    await page.waitForSelector(byId('file-entry'));
    const tops = await page.$$eval(`${byId('file-entry')} button`, (all) => all.map((one) => one.textContent.trim()));
    assert.ok(tops.includes(service.stateFolder) && !tops.includes('/'), tops.join());
    await page.click(`${byId('file-entry')} button:text-is("${service.stateFolder}")`);
    await page.click(`${byId('file-entry')} button:text-is("trap")`);
    await textBecomes(page, 'folder', /trap$/);
    assert.deepEqual(await page.$$eval(byId('file-entry'), (all) => all.map((one) => one.textContent.trim())), ['inside']);
    // From a top-level folder, "up" leads back to the list of folders.
    while (await page.isVisible(byId('folder-up'))) {
      const before = await page.textContent(byId('folder'));
      await page.click(byId('folder-up'));
      await page.waitForFunction(([selector, old]) => document.querySelector(selector)?.textContent !== old, [byId('folder'), before]);
    }
    assert.deepEqual(await page.$$eval(`${byId('file-entry')} button`, (all) => all.map((one) => one.textContent.trim())), tops);
    panel.errorsExpected = true; // the browser logs the refusal
    for (const folder of ['/etc', join(outside, 'etc'), join(outside, '../../../..'), 'etc']) {
      const answer = await page.evaluate(async (path) => (await fetch(`api/files?folder=${encodeURIComponent(path)}`)).status, folder);
      assert.equal(answer, 422, folder);
    }
  }));

  for (const { name, viewport, options, it } of views) {
    it(`shows images that are uploaded and refuses others, on a ${name}`, withPage(viewport, '', options, async (page, panel) => {
      const file = (called, buffer, mimeType = 'image/jpeg') => ({ name: called, mimeType, buffer });
      const jpeg = readFileSync(photo);
      await page.click(byId('way-upload'));
      panel.errorsExpected = true; // the browser logs the refusal
      await page.setInputFiles(byId('upload-images'), [file('film.gif', jpeg, 'image/gif')]);
      await textBecomes(page, 'upload-error', /^film\.gif: only JPEG and PNG images can be uploaded/);
      await page.setInputFiles(byId('upload-images'), [file('notes.jpg', Buffer.from('no image'))]);
      await textBecomes(page, 'upload-error', /^notes\.jpg: this is neither a JPEG nor a PNG\. Nothing was uploaded\.$/);
      await page.setInputFiles(byId('upload-images'), [file('half.jpg', jpeg.subarray(0, jpeg.length / 2))]);
      await textBecomes(page, 'upload-error', /^half\.jpg: this image cannot be read/);
      assert.deepEqual(await cameras(), []);
      panel.errorsExpected = false;

      await page.setInputFiles(byId('upload-images'), [file('one.jpg', jpeg), file('two.jpg', jpeg)]);
      await page.waitForSelector(byId('camera-tile-0'));
      await picturesGoOn(page, 0);
      const [{ source }] = await cameras();
      assert.ok(source.path.startsWith(join(service.stateFolder, 'images/')), source.path);
      assert.equal(await page.textContent(byId('origin-0')), 'recorded');
    }));
  }

  it('disables everything else during an upload of images, which can be cancelled', withPage(DESKTOP, '', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs the cancelled upload
    let goOn;
    const held = new Promise((resolve) => { goOn = resolve; });
    await page.route('**/api/images?*', async (route) => {
      await held;
      await route.continue().catch(() => {}); // the upload was cancelled
    });
    const isImage = (request) => request.url().includes('/api/images?');
    const begin = async () => {
      const begun = page.waitForRequest(isImage);
      await page.setInputFiles(byId('upload-images'), [photo]);
      await begun;
    };
    await page.click(byId('way-upload'));
    await begin();
    for (const other of ['way-address', 'way-files', 'way-upload', 'add-simulator']) assert.ok(await page.isDisabled(byId(other)), other);
    await page.click(byId('upload-cancel'));
    await textBecomes(page, 'upload-error', /^Cancelled\. Nothing was uploaded\.$/);

    await begin();
    const failed = page.waitForEvent('requestfailed', isImage);
    await page.evaluate(() => { location.hash = '#/diagnostics'; });
    await failed;

    await page.evaluate(() => { location.hash = '#/'; });
    await page.click(byId('way-upload'));
    await begin();
    goOn();
    await page.waitForSelector(byId('camera-tile-0'));
    assert.equal((await cameras()).length, 1);
  }));

  it('keeps uploaded images as long as a camera shows them', withPage(DESKTOP, '#/settings/cameras', {}, async (page, panel) => {
    await page.click(byId('way-upload'));
    await page.setInputFiles(byId('upload-images'), [photo]);
    await page.waitForSelector(byId('camera-entry'));
    const [{ source }] = await cameras();
    const folder = source.path.split('/').at(-1);
    await page.click(byId('way-upload'));
    const entry = page.locator(byId('uploaded-folder')).filter({ hasText: folder });
    panel.errorsExpected = true; // the browser logs the refusal
    const remove = async () => {
      await entry.locator(`[aria-label="Remove ${folder}"]`).click();
      await entry.locator('text=Remove these images?').waitFor();
    };
    await remove();
    await page.keyboard.press('Enter');
    await entry.locator('text=Remove these images?').waitFor({ state: 'detached' });
    assert.deepEqual(panel.errors, [], 'nothing is removed unasked');
    await remove();
    await page.click(byId('remove-images'));
    await textBecomes(page, 'upload-error', /\/cameras\/0\/source\/path names these images/);
    await page.click('[aria-label="Remove camera 0"]');
    await becomes(cameras, (list) => list.length === 0);
    await remove();
    await page.click(byId('remove-images'));
    await entry.waitFor({ state: 'detached' });
  }));

  it('does not count a simulated camera as real', withPage(DESKTOP, '', {}, async (page) => {
    await page.click(byId('add-simulator'));
    await page.waitForSelector(byId('camera-tile-0'));
    assert.equal(await page.textContent(byId('origin-0')), 'simulated');
    await textBecomes(page, 'verdict-unreal', /simulated images only/);
    await textBecomes(page, 'check-cameras', /all are running, 1 simulated/);
    // The page now has cameras to show, so the steps collapse to one line with the next one.
    await page.waitForSelector(byId('step-camera'), { state: 'hidden' });
    await textBecomes(page, 'first-steps', /Next: A camera · A real camera is missing: simulated images only/);
    await page.click(byId('steps-all'));
    await stepBecomes(page, 'camera', 'todo');
    await stepBecomes(page, 'calibration', 'todo');
    await page.click(`${byId('step-calibration')} .btn`);
    await page.waitForURL(/#\/calibration\/0$/);
  }));

  it('stays hidden once dismissed', withPage(PHONE, '', phone, async (page) => {
    await page.click(byId('steps-dismiss'));
    await page.waitForSelector(byId('first-steps'), { state: 'detached' });
    await page.reload();
    await page.waitForSelector(byId('add-camera'));
    await textBecomes(page, 'verdict', /NO-GO/);
    assert.equal(await page.locator(byId('first-steps')).count(), 0);
  }));

  // Must be last: it sets a password.
  it('says how a phone opens the panel, with a code once it can', withPage(DESKTOP, '', {}, async (page) => {
    await page.click(byId('address'));
    await textBecomes(page, 'no-address', /listens on this computer only.*ssh -L/);
    assert.equal(await page.locator(byId('qr')).count(), 0, 'no code that leads nowhere');
    await accessible(page, 'the address without a password');
    await page.click(byId('address-password'));
    const fields = page.locator(`${byId('passwords')} input[type="password"]`);
    await fields.nth(0).fill('correct horse');
    await fields.nth(1).fill('correct horse');
    await page.click(`${byId('passwords')} button:has-text("Set password")`);
    await page.waitForSelector(`${byId('access')}[data-may="change"]:has-text("Admin")`);
    await page.click(`${byId('passwords')} button:has-text("Close")`);

    const reachable = Object.values(networkInterfaces()).flat()
      .filter((card) => card.family === 'IPv4' && !card.internal).map((card) => `http://${card.address}:${settings.panel.port}/`);
    const { panel } = await service.statusBecomes((status) => status.panel.addresses.length === reachable.length);
    assert.deepEqual(new Set(panel.addresses), new Set(reachable));
    await page.click(byId('address'));
    if (!reachable.length) {
      await textBecomes(page, 'no-address', /no network card is up/);
      return;
    }
    await textBecomes(page, 'panel-address', /^http/);
    const shown = (await page.textContent(byId('panel-address'))).trim();
    assert.equal(await readCode(page), shown);
    assert.equal((await fetch(`${shown}api/status`)).status, 200, 'the panel answers there');
    await accessible(page, 'the address');
    await page.keyboard.press('Escape');
    await stepBecomes(page, 'password', 'done');
  }));
});
