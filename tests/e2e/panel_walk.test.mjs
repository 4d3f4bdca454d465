// SPDX-License-Identifier: Apache-2.0
// Every page of the panel at every screen size, with zero to eight cameras, and during a match: nothing clipped or
// overlapping, touch targets large enough, images large enough, no axe violations. layout.mjs has the checks and the
// intended exceptions.
//   SSLV_WALK=all          every size, number of cameras and theme; default: a part of them, which takes a minute
//   SSLV_WALK_PAGES=a,b    only addresses that begin with one of these
//   SSLV_WALK_SIZES=WxH,…  only these sizes
//   SSLV_WALK_SHOTS=DIR    also saves a screenshot of everything checked
// Further environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { after, describe, it } from 'node:test';
import { axeFaults, chooseTheme, createBrowser, live, phone } from './browser.mjs';
import { layoutFaults } from './layout.mjs';
import { cameraCounts, findPaths, lookAround, matchFor, nameOfSize, serviceWith, settled, sizes } from './walk.mjs';

const isAll = process.env.SSLV_WALK === 'all';
const list = (name) => process.env[name]?.split(',') ?? null;
const [onlyPages, onlySizes] = [list('SSLV_WALK_PAGES'), list('SSLV_WALK_SIZES')];
const shots = process.env.SSLV_WALK_SHOTS;

const counts = list('SSLV_WALK_CAMERAS')?.map(Number) ?? (isAll ? cameraCounts : [1, 4]);
/** States that change pages only slightly: only the pages themselves are checked, without what their switches show. */
const others = list('SSLV_WALK_CAMERAS') ? [] : [{ count: 0 }, { count: 1, isMatch: true }];
const states = [...counts.map((count) => ({ count, isWhole: true })), ...others];
const usual = ['1366x650', '800x360', '360x780'];
const wanted = sizes.filter((size) => (onlySizes ?? (isAll ? sizes.map(nameOfSize) : usual)).includes(nameOfSize(size)));

/**
 * Whether a state is checked at a size. The slight changes of the other states are checked on the smallest screen only,
 * and one camera needs less space than four.
 */
const isWalked = ({ count, isWhole }, m) => isAll || onlySizes !== null || m === wanted.length - 1 || (isWhole && (count > 1 || counts.length === 1));
/** The combinations at which places within a page are checked in turn. */
const turns = states.flatMap((state, n) => wanted.map((_, m) => `${n} ${m}`).filter((_, m) => state.isWhole && isWalked(state, m)));

/** Lists each fault once, with the places where it occurs. */
function summary(faults) {
  const places = new Map();
  for (const { kind, at, what, where } of faults) {
    const key = `${kind} ${at} ${what}`.replace(/"[^"]*"|\/[\w./]+|\d+(\.\d+)?/g, '');
    if (!places.has(key)) places.set(key, { what: `${kind}: ${at}\n    ${what}`, where: [] });
    if (places.get(key).where.at(-1) !== where) places.get(key).where.push(where);
  }
  const lines = [...places.values()].sort((a, b) => b.where.length - a.where.length)
    .map(({ what, where }) => `${what}\n    on ${where.slice(0, 3).join('\n    on ')}${where.length > 3 ? `\n    and ${where.length - 3} more` : ''}`);
  return `${places.size} faults:\n${lines.slice(0, 60).join('\n')}${lines.length > 60 ? `\n… ${lines.length - 60} more` : ''}`;
}

for (const [n, { count, isMatch, isWhole: isWholeState }] of states.entries()) {
  const service = await serviceWith(count, `239.255.77.${110 + n}`);
  const { address, statusBecomes } = service;
  const endMatch = isMatch ? await matchFor(service) : () => {};
  const stateName = `${count} camera${count === 1 ? '' : 's'}${isMatch ? ' in a match' : ''}`;

  describe(`the panel with ${stateName}`, () => {
    const { aroundTests, openPage } = createBrowser(service, { webgl: true });
    aroundTests(() => statusBecomes(({ cameras, referee }) => cameras.length === count && cameras.every(({ state }) => state === 'running') && (!isMatch || referee.game_is_running)));
    after(endMatch);
    /** Determined once, because they are the same at all sizes. */
    let paths;

    // Simulates the late images of a busy computer: decoding stops once the page has one image of each camera.
    const smallest = wanted.at(-1);
    if (isWholeState && n === counts.length - 1) {
      it(`on ${nameOfSize(smallest)}, with marks on late images`, async () => {
        const { page, errors } = await openPage({ width: smallest.width, height: smallest.height }, smallest.isPhone ? phone : {});
        const faults = [];
        try {
          await page.addInitScript(() => {
            const decode = globalThis.createImageBitmap;
            globalThis.createImageBitmap = (...image) => (globalThis.areImagesLate ? new Promise(() => {}) : decode(...image));
          });
          for (const path of ['overview', 'camera/0', 'calibration/0']) {
            await page.goto('about:blank');
            await page.goto(address(`#/${path}`));
            await settled(page);
            await page.waitForFunction(() => {
              const pictures = [...document.querySelectorAll('main canvas[data-testid^="camera-picture-"]')].filter((one) => one.checkVisibility());
              globalThis.areImagesLate ||= pictures.length > 0 && pictures.every(({ dataset }) => dataset.frame);
              return document.querySelectorAll('main p[data-testid="picture-trouble"]').length === pictures.length && pictures.length > 0;
            });
            for (const fault of await layoutFaults(page, { isTouch: smallest.isPhone })) faults.push({ ...fault, where: path });
          }
        } finally {
          await page.context().close();
        }
        assert.ok(faults.length === 0, summary(faults));
        assert.deepEqual(errors, [], 'errors in the browser console');
      });
    }

    for (const [m, size] of wanted.entries()) {
      if (!isWalked(states[n], m)) continue;
      const { width, height, isPhone } = size;
      // Themes differ in colours, not in layout: one per size, alternating.
      const theme = (n + m) % 2 ? 'light' : 'dark';
      it(`on ${nameOfSize(size)}, ${theme}`, async () => {
        const panel = await openPage({ width, height }, isPhone ? phone : {});
        const { page, errors } = panel;
        const faults = [];
        try {
          await page.goto(address(''));
          await live(page);
          await chooseTheme(page, theme);
          paths ??= await findPaths(page);
          for (const [p, path] of paths.filter((one) => !onlyPages || onlyPages.some((start) => one.startsWith(start))).entries()) {
            // By default: places within a page are alike, so each is checked at one size with one number of cameras;
            // what a page's switches show is checked at one size with the most cameras.
            const isWhole = isWholeState && (isAll || onlyPages !== null);
            if (!isWholeState && path.includes('/')) continue;
            if (!isWhole && path.includes('/') && turns[p % turns.length] !== `${n} ${m}`) continue;
            const isDeep = isWhole || (isWholeState && !path.includes('/') && n === counts.length - 1 && (p + m) % wanted.length === 0);
            await lookAround(page, path, isDeep, async (what) => {
              const where = `#/${path}${what ? `, ${what}` : ''}, ${nameOfSize(size)}, ${stateName}, ${theme}`;
              if (shots) {
                mkdirSync(shots, { recursive: true });
                await page.screenshot({ path: join(shots, `${where.replace(/[^\w.-]+/g, '_')}.png`) });
              }
              // Retry, as a busy computer may not have finished the layout; real faults remain.
              let found = [];
              for (let looks = 0; looks < 10; looks++) {
                found = await layoutFaults(page, { isTouch: isPhone });
                if (!found.length) break;
                await settled(page);
              }
              for (const fault of found) faults.push({ ...fault, where });
              // The other tests run axe on every page, too; here it covers the effects of size and number of cameras.
              if (isAll || (!what && !path.includes('/') && (p + m) % wanted.length === 0)) {
                for (const fault of await axeFaults(page)) faults.push({ kind: 'axe', at: '', what: fault, where });
                if (isAll) {
                  const other = theme === 'dark' ? 'light' : 'dark';
                  await page.evaluate((name) => { document.documentElement.dataset.theme = name; }, other);
                  for (const fault of await axeFaults(page, { runOnly: ['color-contrast', 'link-in-text-block'] })) faults.push({ kind: 'axe', at: '', what: fault, where: `${where}, but ${other}` });
                  await page.evaluate((name) => { document.documentElement.dataset.theme = name; }, theme);
                }
              }
            });
          }
          await settled(page);
        } finally {
          await page.context().close();
        }
        assert.ok(faults.length === 0, summary(faults));
        assert.deepEqual(errors, [], 'errors in the browser console');
      });
    }
  });
}
