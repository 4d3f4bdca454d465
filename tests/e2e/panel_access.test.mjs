// SPDX-License-Identifier: Apache-2.0
// Passwords, roles and the match lock as people meet them in the panel, at desktop and phone size.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { after, before, beforeEach, describe, it } from 'node:test';
import { accessible, byId, createBrowser, DESKTOP, saved, views } from './browser.mjs';
import { becomes, createService, freeUdpPort } from './service.mjs';

const ADMIN = 'correct horse', VIEWER = 'battery staple';
const service = await createService('239.255.77.102');
const panel = createBrowser(service);
const { withPage } = panel;
const SITE = '#/settings/~general';

const GROUP = '224.5.23.102';
let referee, port, timer;
function refereeSays(command) {
  clearInterval(timer);
  timer = setInterval(() => referee.send(Buffer.from([0x10, 1, 0x20, command, 0x3a, 2, 0x0a, 0, 0x42, 2, 0x0a, 0]), port, GROUP), 50);
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
  beforeEach(() => refereeSays(0));
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
          watched.errorsExpected = true; // the browser writes each 401 down
          await page.waitForSelector(`${byId('access')}[data-may="look"]`);
          await renameTo(page, 'By an admin');
          await page.waitForSelector(`${dialog} ${byId('sign-in')}`);
          await accessible(page, 'signing in');
          await page.fill(`${dialog} input`, 'wrong horse');
          await page.click(`${dialog} button:has-text("Sign in")`);
          await page.waitForSelector(`${dialog} [role="alert"]:has-text("not a password of this service")`);
          await page.fill(`${dialog} input`, ADMIN);
          await page.click(`${dialog} button:has-text("Sign in")`);
          await saved(page);
          assert.equal(await site(), 'By an admin');
          await page.waitForSelector(`${byId('access')}[data-may="change"]`);
          await page.click(byId('access'));
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

      it('locks settings while a match runs, and unlocks them for it', async () => {
        await startAfresh();
        await withPage(viewport, SITE, options, async (page, watched) => {
          watched.errorsExpected = true;
          refereeSays(2);
          await becomes(async () => (await (await fetch(service.address('api/session'))).json()).match_lock.locked, Boolean);
          await page.waitForSelector(`${byId('access')}[aria-label*="Locked"]`);
          await renameTo(page, 'In the match');
          await page.waitForSelector(`${dialog}:has-text("A match is running")`);
          await accessible(page, 'a running match');
          await page.click(byId('unlock'));
          await saved(page);
          assert.equal(await site(), 'In the match');
          await page.click(byId('access'));
          await page.click(byId('match-lock'));
          await page.waitForSelector(`${dialog}:has-text("Settings are locked again.")`);
          await page.click(`${dialog} button:has-text("Close")`);
          await renameTo(page, 'Too late');
          await page.click(`${dialog} button:has-text("Keep it locked")`);
          await page.waitForSelector('[role="alert"]:has-text("the game is running")');
        })();
        assert.equal(await site(), 'In the match');
      });
    });
  }

  panel.screenshots([{ file: 'access-dark.jpg', theme: 'dark', path: '', viewport: DESKTOP, options: {}, ready: async (page) => {
    await page.click(byId('access'));
    await page.waitForSelector(dialog);
  } }]);
});
