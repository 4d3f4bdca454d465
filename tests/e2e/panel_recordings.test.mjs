// SPDX-License-Identifier: Apache-2.0
// The page Recordings with the real service: a log started by hand, one of a match, and the actions on them.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { after, before, beforeEach, describe, it } from 'node:test';
import { gunzipSync } from 'node:zlib';
import { accessibleInThemes, byId, createBrowser, DESKTOP, phone, text, textBecomes, views } from './browser.mjs';
import { layoutFaults } from './layout.mjs';
import { gameController } from './league_messages.mjs';
import { becomes, createService, freeUdpPort } from './service.mjs';

const service = await createService('239.255.77.104');
const { address, patch } = service;
const { aroundTests, withPage } = createBrowser(service);
const PATH = '#/recordings';
const ADMIN = 'correct horse';
const HALT = 0, STOP = 1, NORMAL_START = 2;
const FIRST_HALF = 1;

const GROUP = '224.5.23.104';
const port = await freeUdpPort();
service.settings.network.referee = { enabled: true, group: GROUP, port, interface: 'lo' };
service.settings.recording.match_logs = 'by_hand';
let referee, timer;
/** Repeats a referee message until the next call. Without a command, sends nothing. */
function refereeSays(command, yellowGoals = 0, yellow = 'RoboTeam Twente') {
  clearInterval(timer);
  if (command === undefined) return;
  const score = [0x3a, 2, 0x10, yellowGoals]; // protobuf merges this into the yellow team's message
  const said = Buffer.concat([gameController({ yellow: [yellow], blue: ['TIGERs Mannheim'], stage: FIRST_HALF, command }), Buffer.from(score)]);
  timer = setInterval(() => referee.send(said, port, GROUP), 100);
}

const ask = async (path, init) => (await fetch(address(`api/${path}`), init)).json();
const recordings = () => ask('recordings');
const recordingsBecome = (wanted) => becomes(recordings, wanted);
const record = (body) => ask('recordings/match-log', { method: 'POST', body: JSON.stringify(body) });
const logPath = (name) => `recordings/logs/${encodeURIComponent(name)}`;
const stateBecomes = (page, state) => page.waitForSelector(`${byId('match-log')}[data-state="${state}"]`);
const row = (name) => `${byId('log')}[data-name="${name}"]`;
const focused = (page) => page.evaluate(() => document.activeElement?.dataset.testid ?? '');

/** Stops recording and deletes all logs. */
async function clear() {
  refereeSays();
  const { match_log: now } = await recordings();
  if (now.state === 'recording' || now.state === 'paused') await record({ record: false });
  for (const { name } of (await recordings()).logs) await ask(logPath(name), { method: 'DELETE' });
}
/** Records a log by hand; returns its name once the service has indexed it. */
async function makeLog(name) {
  await record({ record: true, name });
  await recordingsBecome(({ match_log: now }) => now.messages.vision > 5 && now.seconds > 1);
  await record({ record: false });
  const { logs } = await recordingsBecome(({ logs: [first] }) => first?.messages && first.seconds !== null);
  return logs[0].name;
}

describe('recordings', () => {
  aroundTests();
  before(async () => {
    referee = createSocket('udp4').bind(0, '127.0.0.1');
    await once(referee, 'listening');
    referee.setMulticastInterface('127.0.0.1');
  });
  beforeEach(async () => {
    await service.restore();
    await clear();
  });
  after(() => {
    clearInterval(timer);
    referee.close();
  });

  for (const { name: view, viewport, options, it: onView } of views) {
    const press = (page, selector) => (options.hasTouch ? page.tap(selector) : page.click(selector));

    onView(`are made by hand under a name, and told while they are (${view})`, withPage(viewport, PATH, options, async (page) => {
      await stateBecomes(page, 'off');
      await textBecomes(page, 'match-log-now', /^Off$/);
      await page.waitForSelector(byId('no-logs'));
      await accessibleInThemes(page, `no recordings, ${view}`);
      await page.fill(byId('log-name'), '../etc');
      await page.waitForSelector('text=Use only A to Z, digits, spaces, - and _');
      assert.ok(await page.isDisabled(byId('record')));
      await page.fill(byId('log-name'), 'warm-up 2');
      await press(page, byId('record'));
      await stateBecomes(page, 'recording');
      await textBecomes(page, 'match-log-now', /^Recording since \d\d:\d\d: warm-up 2, \d+ s, /);
      await textBecomes(page, 'messages-vision', /^[1-9]/);
      const { match_log: now } = await recordings();
      assert.equal(now.started_by, 'hand');
      // The log being written is listed, but cannot be deleted or downloaded yet.
      await page.waitForSelector(`${row(now.name)} >> text=being written`);
      assert.equal(await page.locator(`${row(now.name)} ${byId('delete')}`).count(), 0);
      assert.deepEqual(await layoutFaults(page, { isTouch: options.isMobile ?? false }), []);
      await press(page, byId('stop'));
      await stateBecomes(page, 'off');
      const log = `${row(now.name)}`;
      await page.waitForSelector(`${log} ${byId('download')}`);
      await page.waitForSelector(`${log}:has-text("0 goals")`);
      const kept = (await recordings()).logs[0];
      assert.equal(kept.name, now.name);
      assert.match(await text(page, 'disk-used'), /^[\d.]+ [kMG]?B/);
      const file = await fetch(new URL(await page.getAttribute(`${log} ${byId('download')}`, 'href'), address('')));
      assert.match(file.headers.get('content-type'), /^application\/gzip/);
      assert.equal(gunzipSync(Buffer.from(await file.arrayBuffer())).subarray(0, 12).toString(), 'SSL_LOG_FILE');
    }));

    onView(`are pinned, and deleted when that is meant (${view})`, withPage(viewport, PATH, options, async (page) => {
      const name = await makeLog('one');
      const pin = `${row(name)} ${byId('pin')}`;
      await press(page, pin);
      await page.waitForSelector(`${pin}[aria-pressed="true"]`);
      assert.equal((await recordings()).logs[0].pinned, true);
      await press(page, pin);
      await page.waitForSelector(`${pin}[aria-pressed="false"]`);
      assert.equal((await recordings()).logs[0].pinned, false);
      await press(page, `${row(name)} ${byId('delete')}`);
      // Pressing Enter by accident keeps it.
      await page.waitForSelector(`${row(name)} >> text=Delete this log?`);
      await becomes(() => focused(page), (id) => id === 'delete-not');
      assert.deepEqual(await layoutFaults(page, { isTouch: options.isMobile ?? false }), []);
      await page.keyboard.press('Enter');
      await becomes(() => focused(page), (id) => id === 'delete');
      assert.equal((await recordings()).logs.length, 1);
      await press(page, `${row(name)} ${byId('delete')}`);
      await press(page, byId('delete-now'));
      await page.waitForSelector(byId('no-logs'));
      assert.equal((await recordings()).logs.length, 0);
    }));

    onView(`of a match start with it, and show what happened (${view})`, withPage(viewport, PATH, options, async (page) => {
      await patch({ op: 'replace', path: '/recording/match_logs', value: 'by_game_controller' });
      await stateBecomes(page, 'waiting');
      await page.waitForSelector(byId('hint-controller'));
      refereeSays(STOP);
      await stateBecomes(page, 'recording');
      await page.waitForSelector(byId('hint-controller'), { state: 'detached' });
      await textBecomes(page, 'match-log-now', /: RoboTeam Twente vs TIGERs Mannheim, /);
      const { match_log: { name } } = await recordings();
      // Settings are locked while the game runs, recordings are not.
      refereeSays(NORMAL_START);
      await recordingsBecome(({ match_log: now }) => now.messages.referee > 15);
      refereeSays(STOP, 1);
      const before = (await recordings()).match_log.messages.referee;
      await recordingsBecome(({ match_log: now }) => now.messages.referee > before + 3);
      await press(page, byId('stop'));
      await becomes(() => focused(page), (id) => id === 'keep-recording');
      await press(page, byId('keep-recording'));
      await stateBecomes(page, 'recording');
      await press(page, byId('stop'));
      await press(page, byId('stop-now'));
      await stateBecomes(page, 'left_out');
      await textBecomes(page, 'match-log-now', /^This match is not recorded: 127\.0\.0\.1 stopped its log$/);
      assert.deepEqual(await layoutFaults(page, { isTouch: options.isMobile ?? false }), []);
      await becomes(recordings, ({ logs }) => logs.find((one) => one.name === name)?.goals === 1);
      // Begins a new match, so that the next view's match is recorded, with unlocked settings.
      refereeSays(HALT, 0, 'RoboIME');
      await service.statusBecomes(({ referee: heard }) => !heard.game_is_running);
      await stateBecomes(page, 'waiting');
      refereeSays();

      await press(page, `${row(name)} a >> nth=0`);
      await page.waitForSelector(byId('timeline'));
      const { events } = await ask(`${logPath(name)}/events`);
      const wanted = [...events].sort((a, b) => a.time_s - b.time_s);
      assert.ok(wanted.some(({ kind }) => kind === 'goal') && wanted.some(({ kind }) => kind === 'command'), JSON.stringify(wanted));
      const texts = () => page.$$eval(`${byId('log-event')} p`, (all) => all.map((one) => one.lastChild.textContent.trim()));
      assert.deepEqual(await texts(), wanted.map((event) => event.text));
      await press(page, byId('show-goals'));
      assert.deepEqual(await texts(), wanted.filter(({ kind }) => kind === 'goal').map((event) => event.text));
      await press(page, byId('show-all'));

      // By keyboard from event to event; the list follows.
      await page.focus(byId('timeline'));
      await page.keyboard.press('End');
      await textBecomes(page, 'timeline-tip', new RegExp(`${wanted.at(-1).text.replace(/[.*+?^${}()|[\]\\]/g, '\\$&')}$`));
      assert.equal(await page.locator(`${byId('log-event')}.on`).count(), 1);
      await page.keyboard.press('Home');
      const clock = (s) => `${String(Math.floor(s / 60)).padStart(2, '0')}:${String(Math.floor(s % 60)).padStart(2, '0')}`;
      assert.equal((await text(page, 'timeline-tip')).trim(), `${clock(wanted[0].time_s)} ${wanted[0].text}`);
      assert.equal(await page.getAttribute(byId('timeline'), 'aria-valuenow'), String(Math.round(wanted[0].time_s)));
      await page.keyboard.press('Escape');
      await textBecomes(page, 'timeline-tip', /^Point at the timeline/);
      // By a click at the goal's position.
      const { x, width, y } = await page.locator(byId('timeline')).boundingBox();
      const goal = wanted.find(({ kind }) => kind === 'goal');
      const length = Number(await page.getAttribute(byId('timeline'), 'aria-valuemax'));
      await page.mouse.click(x + Math.min(width - 1, (goal.time_s / length) * width), y + 8);
      await textBecomes(page, 'timeline-tip', /^\d\d:\d\d \S/);

      assert.deepEqual(await layoutFaults(page, { isTouch: options.isMobile ?? false }), []);
      await accessibleInThemes(page, `a log, ${view}`);
    }));
  }

  it('say that a log is gone', withPage(DESKTOP, `${PATH}/2026-01-01_00-00_none.log.gz`, {}, async (page) => {
    await page.waitForSelector(byId('log-gone'));
  }));

  it('say that the service is silent, and what it refuses', withPage(DESKTOP, PATH, {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs failed requests
    await stateBecomes(page, 'off');
    await page.route('**/api/recordings', (route) => route.abort());
    await page.waitForSelector(`${byId('recordings-trouble')}:has-text("Not updating: No answer from the service")`);
    await textBecomes(page, 'match-log-now', /^Unknown/);
    assert.ok(await page.isDisabled(byId('record')));
    await page.unroute('**/api/recordings');
    await page.waitForSelector(byId('recordings-trouble'), { state: 'detached' });
    // Another admin has already started recording, and this page does not know that yet.
    const stale = await recordings();
    await page.route('**/api/recordings', (route) => route.fulfill({ json: stale }));
    await record({ record: true });
    await page.click(byId('record'));
    await page.waitForSelector(byId('match-log-error'));
    const { error } = await record({ record: true });
    assert.equal((await text(page, 'match-log-error')).trim(), error);
    await page.unroute('**/api/recordings');
    await stateBecomes(page, 'recording');
    await page.waitForSelector(byId('match-log-error'), { state: 'detached' });
  }));

  it('are changed by the admin only', withPage({ width: 360, height: 780 }, PATH, phone, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs each 401
    await stateBecomes(page, 'off');
    const answer = await fetch(address('api/passwords/admin'), { method: 'PUT', body: JSON.stringify({ password: ADMIN, admin_password: '' }) });
    const cookie = answer.headers.get('set-cookie').split(';')[0];
    try {
      await page.tap(byId('record'));
      await page.waitForSelector(`${byId('access-dialog')} ${byId('sign-in')}`);
      await page.tap(`${byId('access-dialog')} button:has-text("Cancel")`);
      await page.waitForSelector(byId('match-log-error'));
      assert.equal((await recordings()).match_log.state, 'off');
      await page.tap(byId('record'));
      await page.fill(`${byId('access-dialog')} input`, ADMIN);
      await page.tap(`${byId('access-dialog')} button:has-text("Sign in")`);
      await stateBecomes(page, 'recording');
    } finally {
      await fetch(address('api/recordings/match-log'), { method: 'POST', body: JSON.stringify({ record: false }), headers: { Cookie: cookie } });
      // So that the next test can make changes without a password.
      await service.stop();
      await service.forget();
    }
  }));
});
