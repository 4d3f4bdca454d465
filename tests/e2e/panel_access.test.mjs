// SPDX-License-Identifier: Apache-2.0
// Passwords, roles and the match lock from a user's point of view, at desktop and phone size.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { after, before, beforeEach, describe, it } from 'node:test';
import { accessible, accessibleInThemes, byId, createBrowser, DESKTOP, saved, textBecomes, views } from './browser.mjs';
import { becomes, createService, freeUdpPort } from './service.mjs';

const ADMIN = 'correct horse', VIEWER = 'battery staple';
const service = await createService('239.255.77.102');
const panel = createBrowser(service);
const { withPage } = panel;
const SITE = '#/settings/~general';

const GROUP = '224.5.23.102';
let referee, port, timer;
const HALT = 0, NORMAL_START = 2;
/** First half, 2 : 1, 65 s left. */
function refereeSays(command) {
  clearInterval(timer);
  const timeLeft = [0x18, 0x80, 0xc9, 0xfe, 0x3d];  // 65 000 000 us, as a sint64
  const score = (goals) => [4, 0x0a, 0, 0x10, goals];
  timer = setInterval(() => referee.send(Buffer.from([0x10, 1, ...timeLeft, 0x20, command, 0x3a, ...score(2), 0x42, ...score(1)]), port, GROUP), 50);
}

const site = async (cookie) => (await (await fetch(service.address('api/settings'), { headers: cookie ? { Cookie: cookie } : {} })).json()).settings.site;
const setPassword = (role, password, cookie = '') => fetch(service.address(`api/passwords/${role}`), {
  method: 'PUT', body: JSON.stringify({ password, admin_password: role === 'admin' ? '' : ADMIN }), headers: { Cookie: cookie },
});
async function startAfresh(...roles) {
  await service.stop();
  await service.forget();
  await service.start();
  await service.statusBecomes(({ cameras }) => cameras.every(({ state }) => state === 'running'));
  let cookie = '';
  for (const role of roles) {
    const answer = await setPassword(role, role === 'admin' ? ADMIN : VIEWER, cookie);
    assert.equal(answer.status, 200);
    cookie = answer.headers.get('set-cookie').split(';')[0];
  }
  return cookie;
}

async function renameTo(page, name) {
  const input = page.locator(`${byId('setting-/site')} input`);
  await input.fill(name);
  await input.press('Enter');
}
const dialog = byId('access-dialog');

describe('who may do what, in the panel', () => {
  panel.aroundTests();
  before(async () => {
    port = await freeUdpPort();
    service.settings.network.referee = { enabled: true, group: GROUP, port, interface: 'lo' };
    referee = createSocket('udp4').bind(0, '127.0.0.1');
    await once(referee, 'listening');
    referee.setMulticastInterface('127.0.0.1');
  });
  beforeEach(() => refereeSays(HALT));
  after(async () => {
    clearInterval(timer);
    referee.close();
  });

  for (const { name, viewport, options } of views) {
    describe(name, () => {
      it('sets the first password, and stays signed in with it', async () => {
        await startAfresh();
        await withPage(viewport, '', options, async (page) => {
          await page.click(byId('access'));
          await page.waitForSelector(`${dialog}:has-text("No password is set")`);
          await accessible(page, 'the first password');
          await page.fill('label:has-text("New password") + div input', ADMIN);
          await page.fill('label:has-text("again") + div input', 'correct house');
          await page.waitForSelector(`${dialog}:has-text("The two passwords differ")`);
          assert.ok(await page.isDisabled('button:has-text("Set password")'));
          await page.fill('label:has-text("again") + div input', ADMIN);
          await page.click('button:has-text("Set password")');
          await page.waitForSelector(`${dialog}:has-text("The admin’s password is set.")`);
          await page.click(`${dialog} button:has-text("Close")`);
          await page.waitForSelector(`${byId('access')}[data-may="change"]`);
        })();
        assert.equal((await (await fetch(service.address('api/session'))).json()).may, 'look');
      });

      it('lets everybody look, asks for the password at the first change, and then makes it', async () => {
        await startAfresh('admin');
        await withPage(viewport, SITE, options, async (page, watched) => {
          watched.errorsExpected = true; // the browser logs each 401
          await page.waitForSelector(`${byId('access')}[data-may="look"]`);
          await renameTo(page, 'By an admin');
          await page.waitForSelector(`${dialog} ${byId('sign-in')}`);
          await accessible(page, 'signing in');
          await page.fill(`${dialog} input`, 'wrong horse');
          await page.click(`${dialog} button:has-text("Sign in")`);
          await page.waitForSelector(`${dialog} [role="alert"]:has-text("wrong password")`);
          await page.fill(`${dialog} input`, ADMIN);
          await page.click(`${dialog} button:has-text("Sign in")`);
          await saved(page);
          assert.equal(await site(), 'By an admin');
          await page.waitForSelector(`${byId('access')}[data-may="change"]`);
          await page.click(byId('access'));
          // A wrong password is reported at its input field.
          await page.fill('label:has-text("New password") + div input', 'battery staple');
          await page.fill('label:has-text("again") + div input', 'battery staple');
          await page.fill('label:has-text("Current admin password") + div input', 'wrong horse');
          await page.click('button:has-text("Set password")');
          await page.waitForSelector(`${dialog} [role="alert"]:has-text("wrong password")`);
          await page.click(byId('sign-out'));
          await page.waitForSelector(`${byId('access')}[data-may="look"]`);
          await renameTo(page, 'By nobody');
          await page.click(`${dialog} button:has-text("Cancel")`);
          await page.waitForSelector('[role="alert"]:has-text("sign in with the admin")');
        })();
        assert.equal(await site(), 'By an admin');
      });

      it('shows nothing without the viewers\' password where there is one', async () => {
        await startAfresh('admin', 'viewer');
        const { page, errors } = await panel.openPage(viewport, options);
        try {
          await page.goto(service.address(''));
          await page.waitForSelector(byId('sign-in'));
          assert.equal(await page.locator(byId('camera-tile-0')).count(), 0);
          await accessible(page, 'the door');
          await page.fill('input', VIEWER);
          await page.click('button:has-text("Sign in")');
          await page.waitForSelector(byId('camera-tile-0'));
          await page.waitForSelector(`${byId('access')}[data-may="look"]`);
          assert.deepEqual(errors.filter((text) => !text.includes('401') && !text.includes('WebSocket')), []);
        } finally {
          await page.context().close();
        }
      });

      it('locks settings during a match, says why, and unlocks them on confirmation', async () => {
        await startAfresh();
        await withPage(viewport, SITE, options, async (page) => {
          const click = (selector) => (options.hasTouch ? page.tap(selector) : page.click(selector));
          const refused = [];
          page.on('response', (answer) => { if (answer.status() === 423) refused.push(answer.url()); });
          const field = `${byId('setting-/site')} input`;
          const isLocked = (locked) => page.waitForFunction(([selector, wanted]) => document.querySelector(selector)?.matches(':disabled') === wanted, [field, locked]);

          // The game is not running: the match is shown, but nothing is locked.
          await page.waitForSelector(`${byId('match-bar')}[data-locked="false"]`);
          await textBecomes(page, 'match-score', /^2 : 1$/);
          await textBecomes(page, 'match-stage', /^First half$/);
          await textBecomes(page, 'match-clock', /1:05$/);
          await isLocked(false);

          refereeSays(NORMAL_START);
          await isLocked(true);
          await page.waitForSelector(`${byId('access')}[aria-label*="Locked"]`);
          await textBecomes(page, 'lock-line', /Settings are locked while the game runs/);
          assert.ok(await page.isVisible(byId('lock-line')));
          const reason = await page.locator(field).locator('xpath=ancestor::fieldset[1]').evaluate(({ title, ariaDescription }) => ({ title, ariaDescription }));
          assert.match(reason.title, /a match is running.*unlock them/);
          assert.equal(reason.ariaDescription, reason.title);
          await accessibleInThemes(page, `locked settings on a ${name}`);

          // Enter alone keeps it locked, as does Enter after another word.
          await click(byId('turn-lock'));
          await page.waitForSelector(`${dialog}:has-text("A match is running"):has-text("both teams receive")`);
          await accessible(page, 'a running match');
          await page.keyboard.press('Enter');
          await page.waitForSelector(dialog, { state: 'hidden' });
          await click(byId('turn-lock'));
          assert.ok(await page.isDisabled(byId('unlock')));
          await page.fill(byId('unlock-word'), 'yes');
          await page.keyboard.press('Enter');
          await page.waitForSelector(`${dialog}:has-text("A match is running")`);
          assert.ok((await (await fetch(service.address('api/session'))).json()).match_lock.locked);

          await page.fill(byId('unlock-word'), 'Unlock');
          await click(byId('unlock'));
          await isLocked(false);
          await textBecomes(page, 'lock-line', /unlocked for this match/);
          await renameTo(page, 'In the match');
          await saved(page);
          assert.equal(await site(), 'In the match');

          await click(byId('turn-lock'));
          await isLocked(true);
          // Another person may also unlock it.
          await fetch(service.address('api/match_lock'), { method: 'POST', body: '{"opened": true}' });
          await isLocked(false);
          await click(byId('access'));
          await click(byId('match-lock'));
          await page.waitForSelector(`${dialog}:has-text("Settings are locked again.")`);
          // Here, too, the word must be typed.
          await click(byId('match-lock'));
          await page.waitForSelector(byId('unlock-form'));
          await page.waitForFunction((selector) => document.activeElement?.matches(selector), `${dialog} button[autofocus]`);
          await page.keyboard.press('Escape');
          await isLocked(true);

          // HALT unlocks; when the game controller stops sending, the match is no longer shown.
          refereeSays(HALT);
          await isLocked(false);
          clearInterval(timer);
          await page.waitForSelector(byId('match-bar'), { state: 'detached' });
          assert.deepEqual(refused, [], 'no control was refused after it was pressed');
        })();
        assert.equal(await site(), 'In the match');
      });
    });
  }

  it('asks viewers for no password', async () => {
    await startAfresh('admin');
    await withPage(DESKTOP, '#/colours/0', {}, async (page) => {
      const refused = [];
      page.on('response', (answer) => { if (answer.status() === 401) refused.push(answer.url()); });
      await page.waitForSelector(`${byId('access')}[data-may="look"]`);
      const box = await page.locator(byId('picture')).boundingBox();
      for (const share of [0.3, 0.5, 0.7]) {
        await page.mouse.move(box.x + box.width * share, box.y + box.height * share);
        await page.waitForSelector(byId('pickout'));
      }
      assert.equal(await page.isVisible(dialog), false);
      assert.deepEqual(refused, []);
    })();
  });

  it('disables on every page only the controls that a match locks', async () => {
    await startAfresh();
    refereeSays(NORMAL_START);
    await becomes(async () => (await (await fetch(service.address('api/session'))).json()).match_lock.locked, Boolean);
    await withPage(DESKTOP, '', {}, async (page) => {
      const look = async (path, locked, free, prepare = () => {}) => {
        await page.goto(service.address(path));
        await page.waitForSelector(byId('lock-line'));
        await prepare();
        for (const name of locked) await page.waitForSelector(`${byId(name)}:disabled`);
        for (const name of free) await page.waitForSelector(`${byId(name)}:enabled`);
      };
      await look('#/calibration/0', ['add-exclude', 'add-include', 'add-around', 'mask-undo'], ['mask-labels'], () => page.click(byId('mode-masks')));
      await look('#/colours/0', ['learn', 'tool-grow', 'undo'], ['tool-pick', 'freeze', 'more-tools']);
      await look('#/camera/0', ['setting-/cameras/0/source/light"] input[type="range'], ['freeze', 'still', 'layer-grid']);
      await look('#/field', ['undo'], ['preset-division-a']);
      await look('#/settings/cameras', ['add-simulator'], ['find-cameras']);
      await look('#/settings/~profiles', ['profile-save', 'profile-name'], []);
    })();
  });
});
