// SPDX-License-Identifier: Apache-2.0
// The panel's page of the field and the network from a user's point of view; changes are verified at the service and in
// the packets sent. Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { beforeEach, describe } from 'node:test';
import { accessible, accessibleInThemes, byId, createBrowser, DESKTOP, itLong, saved, views } from './browser.mjs';
import { fieldsOf } from './protobuf.mjs';
import { createService, eventually, freeUdpPort, PATIENCE_MS } from './service.mjs';

const GROUP = '239.255.77.84';
const REFEREE_GROUP = '239.255.77.85';
const LOCAL = '127.0.0.1';

const service = await createService(GROUP);
const { settings, address, patch, statusBecomes } = service;
const refereePort = await freeUdpPort();
settings.network.referee = { group: REFEREE_GROUP, port: refereePort, interface: 'lo' };
const { aroundTests, withPage } = createBrowser(service);

/** A field of a protobuf message: a string, a message or a small number. */
const field = (number, value) => {
  const tag = (kind) => { const one = number * 8 + kind; return one < 128 ? [one] : [(one & 127) | 128, one >> 7]; };
  if (typeof value === 'number') return Buffer.from([...tag(0), value]);
  const bytes = Buffer.from(value);
  return Buffer.concat([Buffer.from([...tag(2), bytes.length]), bytes]);
};

/** Receives a group's packets until one satisfies `wanted`. */
async function received(group, port, wanted) {
  const socket = createSocket({ type: 'udp4', reuseAddr: true });
  try {
    socket.bind(port, group);
    await once(socket, 'listening');
    socket.addMembership(group, LOCAL);
    const signal = AbortSignal.timeout(PATIENCE_MS);
    for (;;) {
      const [packet] = await once(socket, 'message', { signal });
      if (wanted(fieldsOf(packet))) return packet;
    }
  } finally {
    socket.close();
  }
}
const DETECTION = 1;
const GEOMETRY = 2;
/** Field length in a geometry packet; undefined for other packets. */
const lengthIn = (packet) => packet[GEOMETRY] && fieldsOf(fieldsOf(packet[GEOMETRY][0])[1][0])[1][0];
const cameraIn = (packet) => packet[DETECTION] && fieldsOf(packet[DETECTION][0])[4][0];

/** Sends packets repeatedly, from its own socket, until `work` is done. */
async function whileSending(packets, group, port, work) {
  const socket = createSocket('udp4');
  socket.bind(0, LOCAL);
  await once(socket, 'listening');
  socket.setMulticastInterface(LOCAL);
  const timer = setInterval(() => packets().forEach((packet) => socket.send(packet, port, group)), 100);
  try {
    return await work();
  } finally {
    clearInterval(timer);
    socket.close();
  }
}

const setting = (pointer) => `${byId(`setting-${pointer}`)}`;
const inputOf = (pointer) => `${setting(pointer)} input[type="text"]`;
async function type(page, pointer, value) {
  await page.fill(inputOf(pointer), value);
  await page.press(inputOf(pointer), 'Enter');
}
const current = async () => (await (await fetch(address('api/status'))).json());
const vision = async () => (await current()).network;
const dimension = (page, key, mm) => page.waitForSelector(`${byId(`dimension-${key}`)}[data-mm="${mm}"]`);
const carpetShape = (page) => page.$eval(byId('field-carpet'), (rect) => rect.width.baseVal.value / rect.height.baseVal.value);
const carpetBecomes = (page, wanted) => eventually(async () => {
  const shape = await carpetShape(page);
  assert.ok(Math.abs(shape - wanted) < 0.01, `${shape}, not ${wanted}`);
});

describe('panel: field and network', () => {
  aroundTests();
  beforeEach(service.restore);

  for (const { name, viewport, options, it } of views) {
    it(`changes the field by a preset, and takes that back, on a ${name}`, withPage(viewport, '#/field', options, async (page) => {
      await dimension(page, 'field_length', 9000);
      await carpetBecomes(page, 9 / 6);
      await page.waitForSelector(`${byId('preset-division-b')}[data-used]`);
      await page.click(byId('preset-division-a'));
      // A preview changes nothing.
      const row = await page.textContent(`${byId('preset-changes')} tr[data-key="field_length"]`);
      assert.match(row, /9000 mm.*12000 mm/);
      await page.waitForSelector(byId('field-ghost'));
      assert.equal((await current()).field.field_length, 9000);

      await page.click(byId('use-preset'));
      await dimension(page, 'field_length', 12000);
      await carpetBecomes(page, 12 / 9);
      await page.waitForSelector(`${byId('preset-division-a')}[data-used]`);
      const { field: published, network } = await statusBecomes((status) => status.field.field_length === 12000);
      assert.deepEqual([published.goal_width, published.boundary_width_goal_line], [1800, 600]);
      await received(GROUP, network.port, (packet) => lengthIn(packet) === 12000);

      await page.click(byId('undo'));
      await dimension(page, 'field_length', 9000);
      await statusBecomes((status) => status.field.field_length === 9000 && status.field.goal_width === 1000);
    }));

    it(`changes a size by typing, and refuses a wrong one, on a ${name}`, withPage(viewport, '#/field', options, async (page) => {
      await page.focus(inputOf('/field/penalty_area_width'));
      await page.waitForSelector(`${byId('dimension-penalty_area_width')}[data-active]`);
      await type(page, '/field/penalty_area_width', '2345');
      await dimension(page, 'penalty_area_width', 2345);
      await statusBecomes((status) => status.field.penalty_area_width === 2345);

      await type(page, '/field/penalty_area_width', '-5');
      await page.waitForSelector(`${setting('/field/penalty_area_width')} [role="alert"] :text-is("Must be at least 0. The service still uses 2345 mm.")`);
      assert.equal(await page.inputValue(inputOf('/field/penalty_area_width')), '-5');
      assert.equal((await current()).field.penalty_area_width, 2345);

      await type(page, '/field/penalty_area_width', '2000');
      await statusBecomes((status) => status.field.penalty_area_width === 2000);
      // A click on a dimension focuses its number.
      await page.click(`${byId('dimension-field_length')} text`);
      await page.waitForFunction((selector) => document.activeElement === document.querySelector(selector), inputOf('/field/field_length'));
    }));

    it(`edits painted lines by hand on a ${name}`, withPage(viewport, '#/field', options, async (page, panel) => {
      await page.click('text="Lines"');
      const lines = byId('shapes-line');
      await page.click(`${lines} button:has-text("Edit by hand")`);
      await page.waitForSelector(`${lines}[data-own]`);
      const cell = `${lines} [data-column="y1"] input >> nth=0`;
      await page.fill(cell, '2990');
      await page.press(cell, 'Enter');
      await statusBecomes((status) => status.field.field_lines?.[0].y1 === 2990);
      await saved(page);
      // Two lines must not have the same name.
      const names = `${lines} .name input >> nth=1`;
      await page.fill(names, 'TopTouchLine');
      panel.errorsExpected = true; // the browser logs the refusal
      await page.press(names, 'Enter');
      await page.waitForSelector(`${lines} td[role="alert"]:has-text("a name other than that of /field/field_lines/0")`);
      assert.equal((await current()).field.field_lines[1].name, 'BottomTouchLine');
      await page.click(`${lines} button:has-text("From the sizes")`);
      await statusBecomes((status) => status.field.field_lines === null);
      await page.waitForSelector(`${lines}:not([data-own])`);
    }));

    it(`sends on another port, and refuses a wrong group, on a ${name}`, withPage(viewport, '#/field/network', options, async (page, panel) => {
      await page.waitForSelector(`${byId('vision-state')}[data-state="sending"]`);
      const { packets_sent } = await vision();
      await page.waitForFunction(([selector, before]) => Number(document.querySelector(selector)?.textContent.replace(/\D/g, '')) > before, [byId('packets-sent'), packets_sent]);
      const port = await freeUdpPort();
      await type(page, '/network/vision/port', String(port));
      await statusBecomes(({ network }) => network.port === port);
      await received(GROUP, port, (packet) => cameraIn(packet) !== undefined);
      await page.waitForFunction(([selector, wanted]) => document.querySelector(selector)?.value === wanted, [byId('team-address'), `${GROUP}:${port}`]);

      panel.errorsExpected = true; // the browser logs the refusal
      await type(page, '/network/vision/group', '10.0.0.1');
      await page.waitForSelector(`${setting('/network/vision/group')} [role="alert"]:has-text("The service still uses ${GROUP}.")`);
      assert.equal((await vision()).group, GROUP);
      await page.press(inputOf('/network/vision/group'), 'Escape');
      // Lists this computer's network cards.
      const cards = await page.$$eval(`${setting('/network/vision/interface')} option`, (list) => list.map(({ value }) => value));
      assert.ok(cards.includes('') && cards.includes('lo'), String(cards));
    }));

    it(`shows another vision and what it contradicts on a ${name}`, withPage(viewport, '#/field/network', options, async (page) => {
      const { port } = await vision();
      await page.waitForSelector(byId('no-other-vision'));
      const theirs = [
        await received(GROUP, port, (packet) => cameraIn(packet) === 1),
        await received(GROUP, port, (packet) => lengthIn(packet) === 9000),
      ];
      await whileSending(() => theirs, GROUP, port, async () => {
        const other = `${byId('other-vision')}[data-address="${LOCAL}"]`;
        await page.waitForSelector(`${other} ${byId('other-camera')}[data-shared]`);
        const ids = await page.$$eval(`${other} ${byId('other-camera')}`, (list) => list.map(({ textContent }) => textContent.trim()));
        assert.deepEqual(ids, ['1 also ours']);
        await page.waitForSelector(`${other} :text("Sends camera 1, as this service does.")`);
        await patch({ op: 'replace', path: '/field/field_length', value: 9500 });
        await page.waitForSelector(`${other} :text("Sends another field: field length 9000 mm (here 9500 mm).")`);
        await accessible(page, `another vision on a ${name}`);
      });
      await patch({ op: 'replace', path: '/field/field_length', value: 9000 });
      await page.waitForSelector(byId('no-other-vision'));
    }));

    it(`shows what the game controller says on a ${name}`, withPage(viewport, '#/field/network', options, async (page) => {
      let teams = ['TIGERs Mannheim', 'Dire Wolves'];
      const STAGE_FIRST_HALF = 1;
      const COMMAND_HALT = 0, COMMAND_NORMAL_START = 2;
      let command = COMMAND_NORMAL_START;
      const referee = () => [Buffer.concat([
        field(2, STAGE_FIRST_HALF), field(4, command), field(7, field(1, teams[0])), field(8, field(1, teams[1])), field(18, 'the test'),
      ])];
      await whileSending(referee, REFEREE_GROUP, refereePort, async () => {
        const yellow = byId('team-yellow');
        await page.waitForSelector(`${yellow} ${byId('team-name')}:text-is("TIGERs Mannheim")`);
        await page.waitForSelector(`${yellow} ${byId('team-height')}:text-is("143")`);
        await page.waitForSelector(`${byId('team-blue')} ${byId('unknown-team')}:has-text("Dire Wolves")`);
        await page.waitForSelector(`${byId('referee-source')}:has-text("the test at ${LOCAL}")`);
        await page.waitForSelector(`${byId('match-state')}:has-text("running")`);

        // Manual entry during the match, possible only after unlocking.
        await page.waitForSelector(`${inputOf('/teams/blue/robot_height')}:disabled`);
        await accessible(page, `locked settings of the network on a ${name}`);
        await page.click(byId('turn-lock'));
        await page.fill(byId('unlock-word'), 'unlock');
        await page.click(byId('unlock'));
        await type(page, '/teams/blue/robot_height', '147');
        await statusBecomes((status) => status.teams.blue.robot_height === 147);
        await page.click(`${setting('/teams/height_from_referee')} [role="switch"]`);
        await statusBecomes((status) => status.teams.yellow.height_from === 'settings');
        await saved(page);
        await page.waitForSelector(`${yellow} ${byId('team-height')}:text-is("140")`);
        await page.click(`${setting('/teams/height_from_referee')} [role="switch"]`);
        await statusBecomes((status) => status.teams.yellow.height_from === 'referee');
        teams = ['KIKS', 'ER-Force'];
        await page.waitForSelector(`${yellow} ${byId('team-name')}:text-is("KIKS")`);
        await page.waitForSelector(byId('unknown-team'), { state: 'detached' });
        command = COMMAND_HALT;
        await statusBecomes(({ referee: { game_is_running } }) => !game_is_running);
      });
      await patch({ op: 'replace', path: '/teams/blue/robot_height', value: 140 });
    }));

    it(`shows what all cameras together see on a ${name}`, withPage(viewport, '#/field/live', options, async (page) => {
      await page.waitForFunction((selector) => document.querySelectorAll(selector).length === 12, byId('live-robot'));
      await page.waitForSelector(`${byId('live-field')}[data-layer="tracked"]`);
      await page.waitForFunction((selector) => /6 yellow.*6 blue/.test(document.querySelector(selector).getAttribute('aria-label')), byId('live-field'));
      assert.match(await page.textContent(byId('live-stages')), /gather.*clocks.*agreement.*track.*publish/si);
      assert.match(await page.textContent(byId('live-sends')), /not sent/);
      for (const layer of ['raw', 'agreement', 'coverage']) {
        await page.click(byId(`live-layer-${layer}`));
        await page.waitForSelector(`${byId('live-field')}[data-layer="${layer}"]`);
      }
      await page.click(byId('live-layer-agreement'));
      await page.waitForSelector(`${byId('live-agreement')} table`);

      // Without a stack there are no tracks, and the page says so.
      await page.click(byId('live-layer-tracked'));
      await patch({ op: 'replace', path: '/field/stack', value: [] });
      await page.waitForSelector(byId('live-missing'));
      await patch({ op: 'replace', path: '/field/stack', value: ['gather', 'clocks', 'agreement', 'track', 'publish'] });
      await page.waitForSelector(byId('live-missing'), { state: 'detached' });
    }));

    it(`says what is known of the ball on a ${name}`, withPage(viewport, '#/field', options, async (page) => {
      await dimension(page, 'field_length', 9000);
      await page.click('label:text-is("Ball")');
      // The simulated ball is never kicked.
      await page.waitForSelector(`${byId('learnt-ball')} :text("0 kicks and 0 chips")`);
      const refused = await fetch(address('api/field/ball_model/accept'), { method: 'POST' });
      assert.equal(refused.status, 409);
    }));

    itLong(`is accessible and fits on a ${name}`, withPage(viewport, '#/field', options, async (page) => {
      const fits = async (what) => {
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        assert.ok(wide <= 0, `${what} is ${wide} px too wide on a ${name}`);
        if (viewport === DESKTOP) assert.ok(await page.evaluate(() => document.documentElement.scrollHeight <= innerHeight), `${what} scrolls`);
        await accessibleInThemes(page, `${what} on a ${name}`);
      };
      await dimension(page, 'field_length', 9000);
      for (const part of ['Sizes', 'Lines', 'Ball', 'Cameras']) {
        await page.click(`label:text-is("${part}")`);
        await fits(part);
      }
      await page.click(byId('preset-division-a'));
      await page.waitForSelector(byId('preset-changes'));
      await fits('a preset');
      await page.click('nav a:text-is("Network")');
      await page.waitForSelector(byId('team-yellow'));
      await fits('the network');
      await page.click('nav a:text-is("Live")');
      for (const layer of ['tracked', 'raw', 'agreement', 'coverage']) {
        await page.click(byId(`live-layer-${layer}`));
        await page.waitForSelector(`${byId('live-field')}[data-layer="${layer}"]`);
        await fits(`layer ${layer}`);
      }
    }));
  }
});
