// SPDX-License-Identifier: Apache-2.0
// The panel's Camera page: the overlay on the image, and the controls of the camera's source.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { mkdirSync, writeFileSync } from 'node:fs';
import { beforeEach, describe, it } from 'node:test';
import { accessibleInThemes, byId, createBrowser, DESKTOP, freezePicture, itLong, picturesGoOn, saved, views } from './browser.mjs';
import { join } from 'node:path';
import { becomes, createService, eventually } from './service.mjs';

const service = await createService('239.255.77.81');
const { address, patch, statusBecomes } = service;
const { aroundTests, withPage } = createBrowser(service);

const picture = byId('camera-picture-0');
const press = (page, name) => page.click(byId(`layer-${name}`));
const isOn = (page, name) => page.getAttribute(byId(`layer-${name}`), 'aria-pressed').then((value) => value === 'true');
async function setLayers(page, wanted) {
  for (const [name, on] of Object.entries(wanted)) if ((await isOn(page, name)) !== on) await press(page, name);
}
const source = async () => {
  const { settings: { cameras } } = await (await fetch(address('api/settings'))).json();
  return cameras[0].source;
};

/** Mean grey level of the displayed image, once it is above (or below) a limit; runs in the browser. */
const brightness = ([selector, least, most]) => {
  const canvas = document.querySelector(selector);
  if (!canvas?.width) return null;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
  const grey = sum / (data.length / 4) / 3;
  return grey > least && grey < most ? grey : null;
};
const brightnessBecomes = async (page, { above = 0, below = 256 }) => {
  const grey = await page.waitForFunction(brightness, [picture, above, below], { polling: 200 });
  return grey.jsonValue();
};

describe('the camera page', () => {
  aroundTests();
  beforeEach(service.restore);

  for (const { name, viewport, options, it } of views) {
    it(`shows at once what a slider of the source does, on a ${name}`, withPage(viewport, '#/camera/0', options, async (page) => {
      await picturesGoOn(page, 0);
      const before = await brightnessBecomes(page, {});
      const slider = page.getByLabel('Light, slider');
      await slider.scrollIntoViewIfNeeded();
      const { x, y, width, height } = await slider.boundingBox();
      await page.mouse.move(x + width * 0.33, y + height / 2);
      await page.mouse.down();
      for (const share of [0.5, 0.6, 0.7]) await page.mouse.move(x + width * share, y + height / 2);
      await page.mouse.up();
      await brightnessBecomes(page, { above: before * 1.3 });
      await page.waitForSelector(`${byId('setting-/cameras/0/source/light')}[data-changed]`);
      await eventually(async () => {
        const shown = Number(await page.getByLabel('Light', { exact: true }).inputValue());
        assert.ok(shown > 1.5 && shown < 2.6, `light ${shown}`);
        assert.equal((await source()).light, shown, 'saved as shown');
      });
      await saved(page);

      await page.getByLabel('Light: back to 1').click();
      await brightnessBecomes(page, { below: before * 1.1 });
      await becomes(source, ({ light }) => light === 1);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} px too wide`);
    }));

    it(`draws regions round the coloured pixels of the labelled picture on a ${name}`, withPage(viewport, '#/camera/0', options, async (page) => {
      await page.getByLabel('Size').selectOption({ label: 'Full' });
      await setLayers(page, { detections: false, labels: true, regions: true });
      await page.waitForSelector(`${picture}[data-picture="labels"]`);
      await page.waitForFunction(([canvas, mark]) => document.querySelector(canvas)?.width === 780 && document.querySelectorAll(mark).length >= 3, [picture, byId('overlay-regions')]);
      const boxes = await page.evaluate(([canvasName, mark]) => {
        const canvas = document.querySelector(canvasName);
        const { width, height } = canvas;
        const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
        return [...document.querySelectorAll(mark)].flatMap((path) => {
          const colour = path.getAttribute('stroke').match(/\d+/g).map(Number);
          return [...path.getAttribute('d').matchAll(/M([\d.-]+) ([\d.-]+)h([\d.]+)v([\d.]+)/g)].map(([, ...numbers]) => {
            const [x, y, w, h] = numbers.map(Number);
            let own = 0;
            for (let v = y; v < y + h; v++) {
              for (let u = x; u < x + w; u++) {
                const at = (v * width + u) * 4;
                if (Math.hypot(data[at] - colour[0], data[at + 1] - colour[1], data[at + 2] - colour[2]) < 110) own++;
              }
            }
            return { label: path.dataset.label, x, y, w, h, share: own / (w * h) };
          });
        });
      }, [picture, byId('overlay-regions')]);
      const large = boxes.filter(({ w, h }) => w >= 4 && h >= 4);
      assert.ok(large.length > 15, `${large.length} boxes`);
      assert.ok(new Set(large.map(({ label }) => label)).size >= 3, JSON.stringify(large));
      for (const box of large) assert.ok(box.share > 0.3, `pixels of its label in ${JSON.stringify(box)}`);
    }));
  }

  it('hatches only masked areas', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    await picturesGoOn(page, 0);
    // A calibrated camera automatically hides the area beyond its field.
    await page.waitForSelector(byId('overlay-beyond'), { state: 'attached' });
    await patch({ op: 'replace', path: '/cameras/0/mask/beyond_boundary', value: null });
    await page.waitForSelector(byId('overlay-mask'), { state: 'detached' });
    const include = [[100, 50], [700, 50], [700, 500], [100, 500]];
    const exclude = [[300, 200], [400, 200], [400, 300], [300, 300]];
    await patch({ op: 'add', path: '/cameras/0/mask', value: { include: [{ points: include }], exclude: [{ points: exclude }], beyond_boundary: null } });
    await page.waitForSelector(byId('overlay-mask'), { state: 'attached' });
    await setLayers(page, { detections: false, lines: false });
    await freezePicture(page);

    // Screenshots at places of the camera's image: the same frozen frame with and without the mask.
    const places = [{ at: [50, 300], out: true }, { at: [740, 300], out: true }, { at: [350, 250], out: true }, { at: [200, 400], out: false }, { at: [600, 150], out: false }];
    const box = await page.locator(picture).boundingBox();
    async function look() {
      const pictures = [];
      for (const { at: [x, y] } of places) {
        pictures.push(await page.screenshot({ clip: { x: box.x + (x / 780) * box.width - 12, y: box.y + (y / 580) * box.height - 12, width: 24, height: 24 } }));
      }
      return pictures;
    }
    const withMask = await look();
    await press(page, 'mask');
    await page.waitForSelector(byId('overlay-mask'), { state: 'detached' });
    const without = await look();
    places.forEach(({ at, out }, i) => assert.equal(!withMask[i].equals(without[i]), out, `at ${at} it is ${out ? '' : 'not '}to be hatched`));
    await press(page, 'mask');
    await page.waitForSelector(byId('overlay-mask'), { state: 'attached' });
    await patch({ op: 'replace', path: '/cameras/0/mask', value: { include: [], exclude: [], beyond_boundary: null } });
    await page.waitForSelector(byId('overlay-mask'), { state: 'detached' });
    await patch({ op: 'remove', path: '/cameras/0/mask' });
    await page.waitForSelector(byId('overlay-beyond'), { state: 'attached' });
  }));

  it('marks exactly the pixels that are too bright or too dark', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    await picturesGoOn(page, 0);
    await patch({ op: 'replace', path: '/cameras/0/source/light', value: 3 });
    await setLayers(page, { over: true, under: true });
    await page.waitForFunction((selector) => Number(document.querySelector(`${selector} b`)?.textContent) > 0.5, byId('exposure'));
    const seen = await page.evaluate(([pictureName, marksName]) => {
      const pixels = (name) => {
        const canvas = document.querySelector(name);
        return { width: canvas.width, frame: canvas.dataset.frame, data: canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data };
      };
      const [shown, marks] = [pixels(pictureName), pixels(marksName)];
      const count = { over: 0, under: 0, plain: 0, wrong: 0, all: shown.data.length / 4 };
      for (let i = 0; i < shown.data.length; i += 4) {
        const rgb = [...shown.data.slice(i, i + 3)];
        const kind = Math.max(...rgb) >= 250 ? 'over' : Math.max(...rgb) <= 6 ? 'under' : 'plain';
        const [r, , b, alpha] = marks.data.slice(i, i + 4);
        const painted = alpha === 0 ? 'plain' : r > b ? 'over' : 'under';
        count[kind]++;
        if (kind !== painted) count.wrong++;
      }
      return { ...count, sameFrame: shown.frame === marks.frame, sameSize: shown.width === marks.width, percent: Number(document.querySelector('[data-testid="exposure"] b').textContent) };
    }, [picture, byId('overlay-exposure')]);
    assert.ok(seen.sameFrame && seen.sameSize, JSON.stringify(seen));
    assert.equal(seen.wrong, 0, JSON.stringify(seen));
    assert.ok(seen.over > 100 && seen.plain > 100, JSON.stringify(seen));
    assert.ok(Math.abs(seen.percent - (100 * seen.over) / seen.all) < 0.3 * seen.percent, JSON.stringify(seen));
  }));

  it('keeps the layers over a reload', withPage(DESKTOP, '#/camera/0', {}, async (page) => {
    await page.waitForSelector(byId('layer-grid'));
    await setLayers(page, { grid: true, lines: false, regions: true });
    await page.reload();
    await page.waitForSelector(byId('layer-grid'));
    assert.deepEqual(await Promise.all(['grid', 'lines', 'regions', 'detections', 'over'].map((name) => isOn(page, name))), [true, false, true, true, false]);
    await page.waitForSelector('path.grid', { state: 'attached' });
    assert.equal(await page.locator(byId('overlay-lines')).count(), 0);
  }));

  for (const { name, viewport, options, it } of views) {
    it(`tells about a pixel on a ${name}`, withPage(viewport, '#/camera/0', options, async (page) => {
      await picturesGoOn(page, 0);
      await setLayers(page, { detections: false });
      await freezePicture(page);
      const box = await page.locator(picture).boundingBox();
      const [x, y] = [box.x + box.width * 0.3, box.y + box.height * 0.6];
      if (options.hasTouch) await page.touchscreen.tap(x, y);
      else await page.mouse.click(x, y);
      const figures = page.locator(`${byId('pixel')}:visible`);
      await figures.waitFor();
      const said = await figures.evaluate(({ dataset, textContent }) => ({ ...dataset, textContent }));
      assert.ok(Math.abs(said.x - 780 * 0.3) < 4 && Math.abs(said.y - 580 * 0.6) < 4, JSON.stringify(said));
      assert.match(said.textContent, /px.*mm on the floor.*RGB.*hue.*°.*%/s);
      const rgb = await page.evaluate(([selector, px, py]) => {
        const canvas = document.querySelector(selector);
        return [...canvas.getContext('2d').getImageData(Math.floor((px * canvas.width) / 780), Math.floor((py * canvas.height) / 580), 1, 1).data].slice(0, 3);
      }, [picture, Number(said.x), Number(said.y)]);
      assert.deepEqual(said.rgb, rgb.join());
      if (!options.hasTouch) {
        await page.mouse.move(5, 5);
        assert.equal(await figures.count(), 1, 'a clicked one stays');
      }
    }));

    itLong(`is accessible with all it has open on a ${name}`, withPage(viewport, '#/camera/0', options, async (page) => {
      await picturesGoOn(page, 0);
      await page.click(byId('layers-explained'));
      await page.click(byId('controls-all'));
      await setLayers(page, { regions: true, over: true });
      await accessibleInThemes(page, `the camera page on a ${name}`);
    }));
  }

  it('shows and sets the playback controls of a recording', withPage(DESKTOP, '#/camera/1', {}, async (page) => {
    const still = Buffer.from(await (await fetch(address('api/cameras/1/snapshot.jpg?quality=90'))).arrayBuffer());
    const recording = join(service.folder, 'recording');
    mkdirSync(recording);
    for (let i = 10; i < 30; i++) writeFileSync(join(recording, `${i}.jpg`), still);
    await patch({ op: 'replace', path: '/cameras/1/source', value: { backend: 'files', path: recording, loop: true, frame_rate_hz: 1 } });  // lasts longer than the test
    await statusBecomes(({ cameras }) => cameras[1].backend === 'files' && cameras[1].state === 'running');
    const paused = `${byId('control-paused')} [role="switch"]`;
    await page.waitForSelector(paused);
    const isPaused = async () => (await (await fetch(address('api/cameras/1/controls'))).json()).controls.find(({ name }) => name === 'paused').value;
    assert.equal(await isPaused(), false);
    await page.click(paused);
    await page.waitForSelector(`${byId('control-paused')}[data-changed]`);
    await becomes(isPaused, (now) => now === true);
    await page.click(byId('controls-save'));
    await page.waitForSelector(`${byId('control-paused')}:not([data-changed])`);
    const { settings: { cameras } } = await (await fetch(address('api/settings'))).json();
    assert.deepEqual(cameras[1].source.controls, { paused: true });

    // An unsaved change is shown as such after a reload and in another browser, and everyone can revert it.
    await page.click(paused);
    await page.waitForSelector(`${byId('control-paused')}[data-changed]`);
    await becomes(isPaused, (now) => now === false);
    await statusBecomes(({ cameras: [, camera], alerts }) => camera.controls_unsaved === 1 && alerts.some(({ id, title }) => id === 'controls_unsaved' && title === 'Camera 1: 1 control is set and not saved'));
    await page.reload();
    await page.waitForSelector(`${byId('control-paused')}[data-changed]`);
    assert.match(await page.textContent(byId('controls-saved')), /1 not saved/);
    const other = await page.context().newPage();
    await other.goto(address('#/camera/1'));
    await other.waitForSelector(`${byId('control-paused')}[data-changed]`);
    await other.getByLabel('Paused: revert to on').click();
    await other.waitForSelector(`${byId('control-paused')}:not([data-changed])`);
    assert.equal(await isPaused(), true, 'the camera is set back');
    await page.waitForSelector(`${byId('control-paused')}:not([data-changed])`);
    await other.close();
    await statusBecomes(({ cameras: [, camera], alerts }) => camera.controls_unsaved === 0 && !alerts.some(({ id }) => id === 'controls_unsaved'));

    // Revert all at once, and undo saved changes.
    await page.click(paused);
    await page.click(`${byId('control-loop')} [role="switch"]`);
    await page.waitForFunction((card) => document.querySelector(card)?.textContent.includes('2 not saved'), byId('controls-saved'));
    await page.click(byId('controls-revert'));
    await page.waitForFunction((card) => document.querySelector(card)?.textContent.includes('Everything is saved'), byId('controls-saved'));
    assert.equal(await isPaused(), true);
    await patch({ op: 'replace', path: '/cameras/1/source/controls', value: {} });
    assert.equal(await isPaused(), false, 'what it was when it was opened');
  }));
});
