// SPDX-License-Identifier: Apache-2.0
// The page Colours from a user's point of view: the real service with its simulated cameras, in a real browser.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, it } from 'node:test';
import { accessible, byId, chooseTheme, createBrowser, DESKTOP, itLong, live, saved, text, views } from './browser.mjs';
import { becomes as stateBecomes, createService, eventually } from './service.mjs';

const service = await createService('239.255.77.83');
const { address, patch, statusBecomes, settings } = service;
const { aroundTests, withPage } = createBrowser(service, { webgl: true });
// Standing robots can be clicked.
for (const { source } of settings.cameras) source.speed = 0;

const get = async (path) => (await fetch(address(path))).json();
async function post(path, body) {
  const answer = await fetch(address(path), { method: 'POST', body: body === undefined ? undefined : JSON.stringify(body) });
  assert.ok(answer.ok, `${path}: ${answer.status}`);
  return answer.json();
}
const state = (camera = 0) => get(`api/cameras/${camera}/colors`);
const cellsOf = ({ labels }, name) => labels.find((label) => label.name === name).cells;
const colorOf = ({ labels }, name) => [1, 3, 5].map((at) => Number.parseInt(labels.find((label) => label.name === name).color.slice(at, at + 2), 16));
const tableFile = async (camera = 0) => Buffer.from(await (await fetch(address(`api/cameras/${camera}/colors/table`))).arrayBuffer());

/** Polls a camera's colour state until `wanted` is satisfied. */
const becomes = (wanted, camera = 0) => stateBecomes(() => state(camera), wanted, (now) => JSON.stringify({ ...now, light: undefined }));

/** The labels of all cells of a .lut file, ordered U, V, Y. */
function cellsOfFile(file) {
  const magic = file.toString('latin1', 0, 8);
  assert.match(magic, /^SSLVLUT[23]$/);
  const bits = file[8];
  let at = 10;
  for (let i = 0; i < file[9]; i++) at += 2 + file[at + 1];
  if (magic === 'SSLVLUT3') at += 1 + 9 * file[at];  // prints
  const cells = new Uint8Array(1 << (3 * bits));
  for (let to = 0; at < file.length;) {
    const label = file[at++];
    let length = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = file[at++];
      length |= (byte & 127) << shift;
      if (byte < 128) break;
    }
    cells.fill(label, to, to + length);
    to += length;
  }
  return { bits, of: (y, u, v) => cells[(((u >> (8 - bits)) << (2 * bits)) | ((v >> (8 - bits)) << bits) | (y >> (8 - bits)))] };
}

const press = (view) => (view === 'phone' ? 'tap' : 'click');
/** Resets the table to that of the settings, and waits until the page shows it. */
async function ready(page) {
  while ((await state()).undo) await post('api/cameras/0/colors/undo');
  const cells = cellsOf(await state(), 'pink');
  await page.waitForSelector(`${byId('label-pink')}[data-cells="${cells}"]`);
}

async function pixelBecomes(page, name, x, y, color) {
  await page.waitForFunction(([selector, px, py, wanted]) => {
    const canvas = document.querySelector(selector);
    if (!canvas?.width) return false;
    return `${[...canvas.getContext('2d').getImageData(px, py, 1, 1).data].slice(0, 3)}` === wanted;
  }, [byId(name), x, y, String(color)]);
}
/** Waits until more than `more` pixels of a canvas have the colour. */
const countBecomes = (page, name, color, more) => page.waitForFunction(([selector, [r, g, b], least]) => {
  const canvas = document.querySelector(selector);
  if (!canvas?.width) return false;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i] === r && data[i + 1] === g && data[i + 2] === b) count++;
  return count > least;
}, [byId(name), color, more]);

/** Waits until every pixel of the slice matches the service's table. */
async function sliceIsThatOf(page, y) {
  const [now, { bits, of }] = [await state(), cellsOfFile(await tableFile())];
  const side = 1 << bits;
  const step = 256 / side;
  const colors = Object.fromEntries(now.labels.map(({ value, name }) => [value, colorOf(now, name)]));
  const wanted = Array.from({ length: side * side }, (_, i) => colors[of(y, (i % side) * step, (side - 1 - Math.floor(i / side)) * step)].join()).join(' ');
  await page.waitForFunction(([selector, expected]) => {
    const canvas = document.querySelector(selector);
    if (!canvas?.width) return false;
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const seen = [];
    for (let i = 0; i < data.length; i += 4) seen.push(`${data[i]},${data[i + 1]},${data[i + 2]}`);
    return seen.join(' ') === expected;
  }, [byId('slice-canvas'), wanted]);
}

async function freeze(page, view) {
  await page.waitForSelector(`${byId('freeze')}:not([disabled])`);
  await page[press(view)](byId('freeze'));
  await page.waitForSelector(`${byId('still-labels')}[data-drawn]:not([data-drawn="0"])`);
}

/** Screen coordinates of a pixel of the frozen image. */
async function onScreen(page, { x, y }) {
  const canvas = page.locator(byId('still-picture'));
  await canvas.scrollIntoViewIfNeeded();
  const box = await canvas.boundingBox();
  const { width, height } = settings.cameras[0].source;
  return { x: box.x + ((x + 0.5) / width) * box.width, y: box.y + ((y + 0.5) / height) * box.height };
}
/** Centre of a dot with that label, left of the divider. */
const dotOf = async (page, name) => {
  const color = colorOf(await state(), name);
  const found = await page.evaluate(([selector, wanted]) => {
    const canvas = document.querySelector(selector);
    const { width, height } = canvas;
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
    const is = (x, y) => wanted.every((value, i) => data[4 * (y * width + x) + i] === value);
    for (let y = 20; y < height - 20; y++) {
      for (let x = 20; x < width * 0.42; x++) if (is(x, y) && is(x + 2, y) && is(x, y + 2) && is(x + 2, y + 2)) return { x: x + 1, y: y + 1 };
    }
    return null;
  }, [byId('still-labels'), color]);
  assert.ok(found, `there is no ${name} in the left half of the picture`);
  return found;
};
/** Carpet: unlabelled, away from the lines. */
const CARPET = { x: 200, y: 300 };

async function drag(page, from, to, modifier) {
  if (modifier) await page.keyboard.down(modifier);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; i <= 6; i++) await page.mouse.move(from.x + ((to.x - from.x) * i) / 6, from.y + ((to.y - from.y) * i) / 6);
  await page.mouse.up();
  if (modifier) await page.keyboard.up(modifier);
}
/** Screen coordinates of a point in the slice, from its levels. */
async function inSlice(page, u, v) {
  const plane = page.locator(byId('slice'));
  await plane.scrollIntoViewIfNeeded();
  const box = await plane.boundingBox();
  return { x: box.x + ((u + 1) / 256) * box.width, y: box.y + ((255 - v) / 256) * box.height };
}
const fits = async (page) => {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} px too wide`);
};

describe('colours page', () => {
  aroundTests(() => statusBecomes(({ cameras }) => cameras.every(({ robots }) => robots > 0)));

  for (const { name: view, viewport, options, it } of views) {
    const click = (page, name) => page[press(view)](byId(name));

    it(`shows the table in use, on a ${view}`, withPage(viewport, '#/colours/0', options, async (page) => {
      await ready(page);
      const now = await state();
      for (const { name, cells, value } of now.labels) {
        if (value !== 0) assert.equal(Number(await page.getAttribute(byId(`label-${name}`), 'data-cells')), cells, name);
      }
      await sliceIsThatOf(page, 128);
      await page.locator(byId('luma')).focus();
      await page.keyboard.press('PageUp');
      await sliceIsThatOf(page, 144);
      await page.locator(`${byId('sheet')} button`).nth(10).click();
      await sliceIsThatOf(page, 84);
      await fits(page);

      // The bodies in the cube, checked by its pixels.
      await page.locator(byId('cube')).scrollIntoViewIfNeeded();
      await page.waitForSelector(`${byId('cube')}[data-cubes]:not([data-cubes="0"])`);
      await page.waitForFunction((selector) => {
        const canvas = document.querySelector(selector);
        const copy = document.createElement('canvas');
        copy.width = canvas.width;
        copy.height = canvas.height;
        const context = copy.getContext('2d', { willReadFrequently: true });
        return new Promise((resolve) => requestAnimationFrame(() => {
          // Triggers a redraw for this frame; otherwise the buffer would be empty.
          canvas.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }));
          requestAnimationFrame(() => {
            context.drawImage(canvas, 0, 0);
            const { data } = context.getImageData(0, 0, copy.width, copy.height);
            let pink = 0;
            for (let i = 0; i < data.length; i += 4) if (data[i] > 120 && data[i] > 1.5 * data[i + 1] && data[i + 2] > data[i + 1]) pink++;
            resolve(pink > 50);
          });
        }));
      }, `${byId('cube')} canvas`);
    }));

    it(`picks colours in the picture, on a ${view}`, withPage(viewport, '#/colours/0', options, async (page) => {
      await ready(page);
      const before = await state();
      const cyan = colorOf(before, 'cyan');
      await freeze(page, view);
      await click(page, 'label-cyan');
      const at = await onScreen(page, CARPET);
      if (view === 'phone') await page.touchscreen.tap(at.x, at.y);
      else await page.mouse.move(at.x, at.y);
      await page.waitForSelector(`${byId('pickout')}[data-x="${CARPET.x}"][data-y="${CARPET.y}"]`);
      const looked = await get(`api/cameras/0/pixels?x=${CARPET.x}&y=${CARPET.y}&width=1&height=1&still=${await page.getAttribute(byId('still-labels'), 'data-still')}`);
      const [y, u, v] = Buffer.from(looked.yuv, 'base64');
      const words = await text(page, 'pickout');
      for (const value of [y, u, v]) assert.ok(words.includes(String(value)), `${words} has no ${value}`);
      await page.waitForSelector(`${byId('trial')}:has-text("adds"):has-text("to Cyan")`);
      const promised = Number(/adds (\d+) cell/.exec(await text(page, 'trial'))[1]);
      assert.equal(cellsOf(await state(), 'cyan'), cellsOf(before, 'cyan'), 'looking changes nothing');

      if (view === 'phone') await page.tap(byId('act-add'));
      else await page.mouse.click(at.x, at.y);
      await saved(page);
      const added = await becomes((now) => cellsOf(now, 'cyan') > cellsOf(before, 'cyan'));
      assert.equal(cellsOf(added, 'cyan') - cellsOf(before, 'cyan'), promised, 'it does what it says');
      await pixelBecomes(page, 'still-labels', CARPET.x, CARPET.y, cyan);
      await page.waitForSelector(`${byId('area')}[data-count]`);

      if (view === 'phone') await page.tap(byId('act-away'));
      else {
        await page.keyboard.down('Shift');
        await page.mouse.click(at.x, at.y);
        await page.keyboard.up('Shift');
      }
      await becomes((now) => cellsOf(now, 'cyan') < cellsOf(added, 'cyan'));
      await pixelBecomes(page, 'still-labels', CARPET.x, CARPET.y, colorOf(before, 'clear'));

      // A box uses all of the carpet's colours in its area. (A click estimates their spread from nine pixels, and
      // sometimes overestimates it.)
      await click(page, 'tool-box');
      const [from, to] = [await onScreen(page, CARPET), await onScreen(page, { x: CARPET.x + 40, y: CARPET.y + 30 })];
      if (view === 'desktop') {
        await drag(page, from, to);
        await saved(page);
        await becomes((now) => cellsOf(now, 'cyan') > cellsOf(before, 'cyan'));
        await page.waitForFunction(([selector, least]) => Number(document.querySelector(selector)?.dataset.count) >= least, [byId('area'), 41 * 31]);
        await countBecomes(page, 'still-labels', cyan, 1000);
      }
      for (let now = await state(); now.undo; now = await state()) {
        await page.waitForSelector(`${byId('undo')}:not([disabled])`);
        await click(page, 'undo');
        await becomes(({ revision }) => revision > now.revision);
      }
      assert.equal(cellsOf(await state(), 'cyan'), cellsOf(before, 'cyan'));
      await pixelBecomes(page, 'still-labels', CARPET.x, CARPET.y, colorOf(before, 'clear'));
    }));

    it(`paints, fills and grows in the slice, on a ${view}`, withPage(viewport, '#/colours/0', options, async (page) => {
      await ready(page);
      const before = await state();
      await click(page, 'label-cyan');
      await click(page, 'tool-paint');
      // An empty part of the plane.
      const [from, to] = [await inSlice(page, 200, 150), await inSlice(page, 230, 150)];
      if (view === 'desktop') {
        await drag(page, from, to);
        await saved(page);
        const painted = await becomes((now) => cellsOf(now, 'cyan') > 0);
        // The brush covers three cells by 16, and at least one in depth.
        assert.ok(cellsOf(painted, 'cyan') >= 16 * 3, String(cellsOf(painted, 'cyan')));
        assert.equal(painted.steps.length, before.steps.length + 1, 'a stroke is one step');
        await sliceIsThatOf(page, 128);
      } else {
        await page.touchscreen.tap(from.x, from.y);
        await becomes((now) => cellsOf(now, 'cyan') > 0);
        await sliceIsThatOf(page, 128);
      }
      const painted = cellsOf(await state(), 'cyan');

      await click(page, 'label-pink');
      await click(page, 'tool-fill');
      const place = await inSlice(page, 200, 150);
      if (view === 'phone') await page.touchscreen.tap(place.x, place.y);
      else await page.mouse.click(place.x, place.y);
      const filled = await becomes((now) => cellsOf(now, 'cyan') < painted);
      assert.equal(cellsOf(filled, 'pink'), cellsOf(before, 'pink') + painted - cellsOf(filled, 'cyan'));
      await sliceIsThatOf(page, 128);

      await click(page, 'tool-grow');
      const grown = await becomes((now) => cellsOf(now, 'pink') > cellsOf(filled, 'pink'));
      await click(page, 'tool-shrink');
      await becomes((now) => cellsOf(now, 'pink') < cellsOf(grown, 'pink'));

      await click(page, 'tool-erase');
      const there = await inSlice(page, 200, 150);
      const { revision } = await state();
      if (view === 'phone') await page.touchscreen.tap(there.x, there.y);
      else await page.mouse.click(there.x, there.y);
      await becomes((now) => now.revision > revision);
      assert.equal(cellsOfFile(await tableFile()).of(128, 200, 150), 0);
      await sliceIsThatOf(page, 128);

      // By keyboard: undo everything, with one redo in between.
      const steps = (await state()).steps.length;
      for (let i = 0; i < steps; i++) {
        const now = await state();
        await page.keyboard.press('Control+z');
        await becomes(({ revision: next }) => next > now.revision);
      }
      assert.equal(cellsOf(await state(), 'cyan'), 0);
      assert.equal(cellsOf(await state(), 'pink'), cellsOf(before, 'pink'));
      await page.keyboard.press('Control+Shift+Z');
      await becomes((now) => cellsOf(now, 'cyan') > 0);
      // Shows whose step it is.
      await page.waitForSelector(`${byId('undo')}[title^="Undo: painted cyan ("][title*=" cell"][title*="127.0.0.1, "]`);
      await click(page, 'undo');
      await becomes((now) => cellsOf(now, 'cyan') === 0);
      await sliceIsThatOf(page, 128);
    }));

    it(`shows thin margins and widens them, on a ${view}`, withPage(viewport, '#/colours/0', options, async (page) => {
      await ready(page);
      const before = await becomes(({ margins }) => margins?.length > 0);
      await click(page, 'show-margins');
      await page.waitForSelector(`${byId('margins')}[data-known="true"]`);
      for (const { label, surface } of before.margins) if (surface === 'carpet') await page.waitForSelector(`${byId(`margin-${label}`)}[data-kind="ok"]`);
      assert.equal(await page.locator(byId('margin-trial')).count(), 0, 'there is nothing to promise');

      // The carpet's colour in 1.5 times the light becomes green.
      const { mean } = await get(`api/cameras/0/pixels?x=${CARPET.x}&y=${CARPET.y}&width=9&height=9`);
      const at = mean.map((value, i) => Math.round(i === 0 ? 1.5 * value : 128 + 1.5 * (value - 128)));
      const painted = await post('api/cameras/0/colors/edits', { commands: [{ op: 'paint', label: 'green', shape: 'box', at, radius: [6, 10, 10], over: 'clear' }] });
      const row = byId('margin-green');
      await page.waitForSelector(`${row}[data-kind="warn"]:has-text("carpet becomes green at +"):has-text("thin")`);
      assert.equal(await page.locator(`${byId('margins')} li`).first().getAttribute('data-testid'), 'margin-green', 'the least comes first');
      await page.waitForSelector(`${byId('show-margins')} .chip.warn:has-text("%")`);
      await page.waitForSelector(`${byId('margin-trial')}:has-text("cells of Green")`);
      await accessible(page, `Colours with a thin margin, ${view}`);
      await fits(page);

      // The service repeatedly measures the carpet; retry if it did so between the preview and the click.
      let widened = null;
      await eventually(async () => {
        if (widened) {
          await click(page, 'undo');
          await page.waitForSelector(`${row}[data-kind="warn"]`);
        }
        const { revision } = await state();
        await page.waitForSelector(`${byId('margin-trial')}:has-text("cells of Green")`);
        const promised = Number(/clear ([\d\u2009]+) cells of Green/.exec(await text(page, 'margin-trial'))[1].replaceAll('\u2009', ''));
        await click(page, 'widen-margins');
        await page.waitForSelector(`${row}[data-kind="ok"]`);
        widened = await becomes((now) => now.revision > revision);
        assert.equal(cellsOf(painted.state, 'green') - cellsOf(widened, 'green'), promised, 'it does what it says');
      });
      assert.equal(widened.undo.what, 'widened the margins to carpet and floor');
      await statusBecomes(({ cameras }) => cameras[0].robots > 0);

      await click(page, 'undo');
      await page.waitForSelector(`${row}[data-kind="warn"]`);
      assert.equal(cellsOf(await state(), 'green'), cellsOf(painted.state, 'green'));
      // A newly opened page shows it first.
      await page.reload();
      await page.waitForSelector(`${row}[data-kind="warn"]`);
      await post('api/cameras/0/colors/undo');
      await page.waitForSelector(`${row}[data-kind="ok"]`);
    }));

    it(`learns all colours, on a ${view}`, withPage(viewport, '#/colours/0', options, async (page) => {
      await ready(page);
      const { cameras: [{ robots }] } = await statusBecomes(({ cameras }) => cameras[0].robots > 0);
      // Without the dots' colours no robot is found.
      await post('api/cameras/0/colors/edits', { commands: ['pink', 'green', 'yellow', 'blue'].map((label) => ({ op: 'remove', label })) });
      await statusBecomes(({ cameras }) => cameras[0].robots === 0);
      const empty = await tableFile();
      await click(page, 'learn');
      await page.waitForSelector(`${byId('learning')}[data-learnt="true"]`);
      assert.deepEqual(await tableFile(), empty, 'nothing changes before it is accepted');
      assert.equal(await page.getAttribute(byId('learn-before'), 'data-robots'), '0');
      assert.equal(Number(await page.getAttribute(byId('learn-after'), 'data-robots')), robots);
      assert.ok(await page.locator(byId('taught')).count() > 0);
      assert.ok(await page.locator(byId('learnt-color')).count() >= 5);
      assert.ok(Number((await text(page, 'changed-cells')).replace(/\s/g, '')) > 0);
      await click(page, 'learn-labels');
      const pink = colorOf(await state(), 'pink');
      const pinkIn = (when) => page.waitForFunction(([selector, [r, g, b]]) => {
        const pane = document.querySelector(selector);
        const canvas = pane?.querySelector('canvas');
        if (!/true$/.test(pane?.dataset.drawn ?? '')) return null;
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;
        for (let i = 0; i < data.length; i += 4) if (data[i] === r && data[i + 1] === g && data[i + 2] === b) count++;
        return { count };
      }, [byId(`learn-${when}`), pink]).then((handle) => handle.jsonValue()).then(({ count }) => count);
      assert.equal(await pinkIn('before'), 0);
      assert.ok(await pinkIn('after') > 20);
      await fits(page);

      await click(page, 'learn-reject');
      await page.waitForSelector(byId('picture'));
      assert.deepEqual(await tableFile(), empty);

      await click(page, 'learn');
      await page.waitForSelector(`${byId('learning')}[data-learnt="true"]`);
      await click(page, 'learn-accept');
      await page.waitForSelector(byId('picture'));
      await statusBecomes(({ cameras }) => cameras[0].robots === robots);
      assert.notDeepEqual(await tableFile(), empty);
      await click(page, 'undo');
      await statusBecomes(({ cameras }) => cameras[0].robots === 0);
      assert.deepEqual(await tableFile(), empty);
      await click(page, 'undo');
      await statusBecomes(({ cameras }) => cameras[0].robots === robots);
    }));

    it(`learns with hints, on a ${view}`, withPage(viewport, '#/colours/0', options, async (page) => {
      await ready(page);
      const { cameras: [{ robots }] } = await statusBecomes(({ cameras }) => cameras[0].robots > 0);
      await freeze(page, view);
      const hints = { pink: await dotOf(page, 'pink'), green: await dotOf(page, 'green') };
      await post('api/cameras/0/colors/edits', { commands: Object.keys(hints).map((label) => ({ op: 'remove', label })) });
      await statusBecomes(({ cameras }) => cameras[0].robots === 0);
      const without = await tableFile();
      await click(page, 'more-tools');
      await click(page, 'guide');
      await page.waitForSelector(byId('guide-bar'));
      for (const [label, dot] of Object.entries(hints)) {
        await click(page, `label-${label}`);
        const at = await onScreen(page, dot);
        if (view === 'phone') {
          await page.touchscreen.tap(at.x, at.y);
          await page.tap(`${byId('act-add')}:has-text("Add hint for ${label}")`);
        } else await page.mouse.click(at.x, at.y);
        await page.waitForSelector(`${byId('guide-bar')}:has-text("next: ${label[0].toUpperCase()}${label.slice(1)}")`);
      }
      await page.waitForFunction((selector) => document.querySelectorAll(selector).length === 2, byId('hint-pin'));
      assert.deepEqual(await tableFile(), without, 'a hint edits nothing');
      await click(page, 'guide-learn');
      await page.waitForSelector(`${byId('learning')}[data-learnt="true"]`);
      assert.equal(Number(await page.getAttribute(byId('learn-after'), 'data-robots')), robots);
      await click(page, 'learn-accept');
      await page.waitForSelector(byId('picture'));
      await statusBecomes(({ cameras }) => cameras[0].robots === robots);
      await post('api/cameras/0/colors/reset');
    }));

    for (const theme of ['dark', 'light']) {
      itLong(`is accessible on a ${view}, ${theme}`, withPage(viewport, '#/colours/0', options, async (page) => {
        await chooseTheme(page, theme);
        await ready(page);
        await freeze(page, view);
        await click(page, 'label-pink');
        const at = await onScreen(page, CARPET);
        if (view === 'phone') await page.touchscreen.tap(at.x, at.y);
        else await page.mouse.move(at.x, at.y);
        await page.waitForSelector(byId('pickout'));
        await accessible(page, `Colours, ${view}, ${theme}`);
        await click(page, 'more-tools');
        await click(page, 'show-light');
        await page.waitForSelector(byId('light'));
        await accessible(page, `Colours with its menu and the light, ${view}, ${theme}`);
        await click(page, 'show-margins');
        await page.waitForSelector(`${byId('margins')}[data-known="true"]`);
        await accessible(page, `Colours with its menu and margins, ${view}, ${theme}`);
        if (view !== 'phone') return;
        const small = await page.evaluate(() => [...document.querySelectorAll('.colours :is(button, a, input:not(.vh), select)')]
          .filter((one) => one.offsetParent && !one.closest('[data-testid="sheet"], .tick, .switch, .seg') && (one.getBoundingClientRect().height < 43.5 || one.getBoundingClientRect().width < 43.5))
          .map((one) => one.outerHTML.slice(0, 90)));
        assert.deepEqual(small, [], 'targets smaller than a finger');
      }));
    }
  }

  it('copies, exports, imports and resets', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
    await ready(page);
    const more = async (name) => { await page.click(byId('more-tools')); await page.click(byId(name)); };
    await page.click(byId('label-pink'));
    await more('remove');
    await becomes((now) => cellsOf(now, 'pink') === 0);
    const without = await tableFile();
    const files = [];
    for (const name of ['export-lut', 'export-json']) {
      await page.click(byId('more-tools'));
      const [download] = await Promise.all([page.waitForEvent('download'), page.click(byId(name))]);
      files.push({ name: download.suggestedFilename(), path: await download.path() });
    }
    assert.deepEqual(readFileSync(files[0].path), without);
    await more('copy-from-1');
    const other = await state(1);
    await becomes((now) => cellsOf(now, 'pink') === cellsOf(other, 'pink'));
    assert.deepEqual(cellsOfFile(await tableFile()).bits, cellsOfFile(await tableFile(1)).bits);
    for (const { name, path } of files) {
      await page.setInputFiles(byId('import-file'), { name, mimeType: 'application/octet-stream', buffer: readFileSync(path) });
      await becomes((now) => cellsOf(now, 'pink') === 0);
      assert.deepEqual(await tableFile(), without, name);
      await page.click(byId('undo'));
      await becomes((now) => cellsOf(now, 'pink') > 0);
    }
    await page.click(byId('more-tools'));
    await page.getByLabel('Replace with').selectOption('cyan');
    const { labels } = await state();
    await page.click(byId('replace'));
    const replaced = await becomes((now) => cellsOf(now, 'pink') === 0);
    assert.equal(cellsOf(replaced, 'cyan'), labels.find(({ name }) => name === 'pink').cells);
    await more('reset');
    await becomes((now) => now.origin === 'classes' && cellsOf(now, 'cyan') === 0);
  }));

  it('shows the service\'s error for an invalid file, and keeps the table', withPage(DESKTOP, '#/colours/0', {}, async (page, panel) => {
    await ready(page);
    const before = await tableFile();
    panel.errorsExpected = true; // the browser logs the refused request
    await page.click(byId('more-tools'));
    await page.setInputFiles(byId('import-file'), { name: 'notes.lut', mimeType: 'application/octet-stream', buffer: Buffer.from('no table at all') });
    await page.waitForSelector(`${byId('file-problem')}:has-text("notes.lut"):has-text("The table has not changed")`);
    assert.deepEqual(await tableFile(), before);
  }));

  itLong('loses nothing when two people edit at once', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
    await ready(page);
    const other = await page.context().newPage();
    await other.goto(address('#/colours/0'));
    await live(other);
    await other.waitForSelector(`${byId('label-pink')}[data-cells]`);
    for (const [one, label] of [[page, 'cyan'], [other, 'black']]) {
      await one.click(byId(`label-${label}`));
      await one.click(byId('tool-paint'));
    }
    const strokes = 4;
    const stroke = async (one, v) => {
      for (let i = 0; i < strokes; i++) {
        const [from, to] = [await inSlice(one, 20 + 50 * i, v), await inSlice(one, 44 + 50 * i, v)];
        await drag(one, from, to);
      }
    };
    await Promise.all([stroke(page, 10), stroke(other, 30)]);
    await becomes(({ steps }) => steps.length === 2 * strokes);
    const { of } = cellsOfFile(await tableFile());
    for (let i = 0; i < strokes; i++) {
      for (const u of [20, 32, 44]) {
        assert.equal(of(128, u + 50 * i, 10), 6, `cyan at ${u + 50 * i}`);
        assert.equal(of(128, u + 50 * i, 30), 9, `black at ${u + 50 * i}`);
      }
    }
    await sliceIsThatOf(page, 128);
    await sliceIsThatOf(other, 128);
    await other.close();
    await post('api/cameras/0/colors/reset');
  }));

  it('follows the light, and says what it does', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
    await ready(page);
    await page.click(byId('show-light'));
    const card = `${byId('light')}`;
    await page.waitForSelector(`${card}[data-state="off"]`);
    await page.getByRole('switch', { name: 'Follows the light' }).click();
    await saved(page);
    await page.waitForSelector(`${card}[data-state="following"]`);
    assert.equal((await get('api/settings')).settings.cameras[0].follow_light.enabled, true);
    // Once the follower measures a gain, it knows the colours in this light.
    await becomes(({ light }) => light.gain.some((value) => value !== 1));
    await patch({ op: 'add', path: '/cameras/0/source/light', value: 0.75 });
    await page.waitForSelector(`${byId('light-revert')}:not([disabled])`);
    const accepted = await tableFile();
    const inLight = async () => Buffer.from(await (await fetch(address('api/cameras/0/colors/table?light=true'))).arrayBuffer());
    assert.notDeepEqual(await inLight(), accepted);
    await page.click(byId('light-keep'));
    await becomes(({ light }) => !light.changed);
    assert.notDeepEqual(await tableFile(), accepted);
    await page.click(byId('undo'));
    await becomes(({ undo }) => undo === null);
    assert.deepEqual(await tableFile(), accepted);
    // Changes by another client are shown here, too.
    await patch({ op: 'replace', path: '/cameras/0/follow_light/enabled', value: false });
    await page.waitForSelector(`${card}[data-state="off"]`);
    await patch({ op: 'replace', path: '/cameras/0/source/light', value: 1 });
    await page.waitForSelector('[role="switch"][aria-label="Follows the light"][aria-checked="false"]');
  }));

  it('stays as it is while the camera is away', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
    await ready(page);
    await page.click(byId('show-light'));
    await page.waitForSelector(byId('light'));
    const { source } = (await get('api/settings')).settings.cameras[0];
    try {
      await patch({ op: 'replace', path: '/cameras/0/source', value: { backend: 'files', path: join(service.folder, 'no-such-recording') } });
      await statusBecomes(({ cameras }) => cameras[0].state === 'lost' && cameras[0].pixel_format === null);
      await page.waitForSelector(`${byId('picture')}:has-text("no-such-recording")`);
      assert.ok(await page.isVisible(byId('light')), 'what was open is still open');
    } finally {
      await patch({ op: 'replace', path: '/cameras/0/source', value: source });
    }
    await statusBecomes(({ cameras }) => cameras[0].state === 'running' && cameras[0].pixel_format === 'uyvy');
    assert.ok(await page.isVisible(byId('light')));
  }));

  it('has nothing to set up for a camera without colours', withPage(DESKTOP, '#/colours/1', {}, async (page) => {
    await ready(page);
    try {
      await patch({ op: 'replace', path: '/cameras/1/source/pixel_format', value: 'mono8' });
      await page.waitForSelector(`${byId('no-colours')}:has-text("mono8")`);
    } finally {
      await patch({ op: 'replace', path: '/cameras/1/source/pixel_format', value: 'uyvy' });
    }
    await page.waitForSelector(byId('picture'));
  }));

  // Must be last: a step whose label was removed cannot be undone.
  it('supports custom labels', withPage(DESKTOP, '#/colours/0', {}, async (page) => {
    await ready(page);
    await page.click(byId('new-label'));
    await page.fill(byId('new-label-name'), 'cup');
    await page.fill(byId('new-label-color'), '#8040ff');
    await page.click(byId('new-label-add'));
    await page.waitForSelector(byId('label-cup'));
    assert.deepEqual((await get('api/settings')).settings.own_labels, [{ value: 10, name: 'cup', color: '#8040ff' }]);
    await page.click(byId('label-cup'));
    await page.click(byId('tool-paint'));
    const at = await inSlice(page, 20, 20);
    await page.mouse.click(at.x, at.y);
    await becomes((now) => cellsOf(now, 'cup') > 0);
    await sliceIsThatOf(page, 128);
    await pixelBecomes(page, 'slice-canvas', 10, 117, [128, 64, 255]);
    // A hidden label is drawn like no label.
    await page.click(byId('eye-cup'));
    await pixelBecomes(page, 'slice-canvas', 10, 117, colorOf(await state(), 'clear'));
    await page.click(byId('drop-cup'));
    await page.waitForSelector(byId('label-cup'), { state: 'detached' });
    assert.deepEqual((await get('api/settings')).settings.own_labels, []);
    await post('api/cameras/0/colors/reset');
  }));
});
