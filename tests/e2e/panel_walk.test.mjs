// SPDX-License-Identifier: Apache-2.0
// Every page of the panel at every size of screen, with none to eight cameras, and in a match: nothing cut, nothing
// overlapping, targets for fingers, images that can be used, axe clean. layout.mjs says what is looked for, and what is
// meant to be as it is.
//   SSLV_WALK=all          every size, number of cameras and theme; else a part of them, which takes a minute
//   SSLV_WALK_PAGES=a,b    only addresses that begin with one of these
//   SSLV_WALK_SIZES=WxH,…  only these sizes
//   SSLV_WALK_SHOTS=DIR    also keeps an image of all that is looked at
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
/** What only changes a little on each page: the pages themselves, without what their switches show. */
const others = list('SSLV_WALK_CAMERAS') ? [] : [{ count: 0 }, { count: 1, isMatch: true }];
const states = [...counts.map((count) => ({ count, isWhole: true })), ...others];
const usual = ['1366x650', '800x360', '360x780'];
const wanted = sizes.filter((size) => (onlySizes ?? (isAll ? sizes.map(nameOfSize) : usual)).includes(nameOfSize(size)));

/**
 * Whether a state is looked at on a size. What the others change of a page is found where there is least room, and with
 * one camera there is more room than with four.
 */
const isWalked = ({ count, isWhole }, m) => isAll || onlySizes !== null || m === wanted.length - 1 || (isWhole && (count > 1 || counts.length === 1));
/** Where a place within a page is looked at, by turns. */
const turns = states.flatMap((state, n) => wanted.map((_, m) => `${n} ${m}`).filter((_, m) => state.isWhole && isWalked(state, m)));

/** The same fault of many places is told once, with the places. */
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
    /** Found once: they are the same at all sizes. */
    let paths;

    for (const [m, size] of wanted.entries()) {
      if (!isWalked(states[n], m)) continue;
      const { width, height, isPhone } = size;
      // Themes differ in colours, not in places: one each, by turns.
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
            // Unless all is asked for: places within a page are alike, so each at one size with one number of cameras;
            // what a page's switches show at one size with the most cameras.
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
              // What a busy computer has not laid out yet is no fault; what is one stays.
              let found = [];
              for (let looks = 0; looks < 10; looks++) {
                found = await layoutFaults(page, { isTouch: isPhone });
                if (!found.length) break;
                await settled(page);
              }
              for (const fault of found) faults.push({ ...fault, where });
              // The other tests do it with every page, too; here for what a size or a number of cameras changes.
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
