// SPDX-License-Identifier: Apache-2.0
// Colour tables from outside: edited, learnt, imported and followed through the API, and checked in the label image, in
// the detections and after a restart.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, it } from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { createService, PATIENCE_MS, root } from './service.mjs';

const openApi = JSON.parse(readFileSync(join(root, 'docs/openapi.json'), 'utf8'));
const service = await createService('239.255.77.82');
// Standing robots, so that colours can be learnt from them and then checked.
for (const { source } of service.settings.cameras) source.speed = 0;

async function ask(method, path, body, expected = 200) {
  const raw = body instanceof Uint8Array;
  const answer = await fetch(service.address(`api/cameras/0/${path}`), {
    method, body: body === undefined || raw ? body : JSON.stringify(body),
  });
  const text = await answer.text();
  assert.equal(answer.status, expected, `${method} ${path}: ${text.slice(0, 500)}`);
  return JSON.parse(text);
}
const get = (path, expected) => ask('GET', path, undefined, expected);
const post = (path, body, expected) => ask('POST', path, body, expected);
const edit = (...commands) => post('colors/edits', { commands });
const bytes = async (path) => {
  const answer = await fetch(service.address(`api/cameras/0/${path}`));
  assert.equal(answer.status, 200);
  return new Uint8Array(await answer.arrayBuffer());
};
const cellsOf = (state, label) => state.labels.find(({ name }) => name === label).cells;

/** The labels of a still according to the current table, with functions to look up a pixel and to count a label. */
async function labelsOf(still) {
  const data = await bytes(`stills/${still}/labels`);
  const width = data[0] | data[1] << 8, height = data[2] | data[3] << 8;
  const labels = new Uint8Array(width * height);
  let at = 4, to = 0;
  while (at < data.length) {
    const label = data[at++];
    let length = 0, shift = 0;
    do { length |= (data[at] & 0x7f) << shift; shift += 7; } while (data[at++] & 0x80);
    labels.fill(label, to, to + length);
    to += length;
  }
  assert.equal(to, width * height);
  return { width, height, at: (x, y) => labels[y * width + x], count: (label) => labels.reduce((n, l) => n + (l === label ? 1 : 0), 0) };
}

async function becomes(look, complaint) {
  const deadline = Date.now() + PATIENCE_MS;
  for (;;) {
    const seen = await look();
    if (seen) return seen;
    assert.ok(Date.now() < deadline, typeof complaint === 'function' ? complaint() : complaint);
    await pause(20);
  }
}
const detections = async () => {
  const status = await (await fetch(service.address('api/status'))).json();
  return status.cameras[0];
};

/** Brightness of the carpet in the newest image, in grey levels. */
const carpetLuma = async () => {
  const { still, width, height } = await post('stills', undefined, 201);
  return (await get(`pixels?x=${Math.round(width * 0.03)}&y=${Math.round(height * 0.5)}&width=9&height=9&still=${still}`)).mean[0];
};
/** After a change, images in the old light still arrive for a while; the follower would learn from them. */
const lightIsBack = () => becomes(async () => Math.abs(await carpetLuma() - fullLuma) < 4, 'the light is not back');

const PINK = 5, CYAN = 6;
let pictureRobots, fullLuma;

describe('colour tables', () => {
  before(async () => {
    await service.start();
    // Images are all the same; after 20 frames the memory of each stage has settled.
    await service.statusBecomes(({ cameras }) => cameras.every(({ robots, frames }) => robots > 0 && frames > 20));
    pictureRobots = (await detections()).robots;
    fullLuma = await carpetLuma();
  });
  after(() => service.end());

  it('are those of the settings until somebody edits them', async () => {
    const state = await get('colors');
    assert.equal(state.origin, 'classes');
    assert.equal(state.bits, 7);
    assert.ok(cellsOf(state, 'pink') > 0);
    assert.equal(state.undo, null);
  });

  it('include a picked carpet until the pick is undone, shown in the labelled image', async () => {
    const { still, width, height } = await post('stills', undefined, 201);
    const before = await labelsOf(still);
    assert.equal(before.count(CYAN), 0);
    // Carpet beside the lines, where no robot stands.
    const place = { x: Math.round(width * 0.03), y: Math.round(height * 0.5), width: 9, height: 9 };
    const looked = await get(`pixels?x=${place.x}&y=${place.y}&width=9&height=9&still=${still}`);
    assert.equal(looked.count, 81);
    assert.ok(looked.shares[0].label === 'clear' && looked.shares[0].share > 0.9, 'carpet has no label yet');

    const tried = await post('colors/edits', { commands: [{ op: 'pick', label: 'cyan', still, ...place }], try: true });
    assert.ok(tried.cells > 0);
    assert.equal((await labelsOf(still)).count(CYAN), 0, 'trying changes nothing');

    const done = await edit({ op: 'pick', label: 'cyan', still, ...place });
    assert.equal(done.cells, tried.cells);
    await service.logBecomes(/audit: .*colors\/edits/);
    assert.equal(service.log().match(/audit: .*colors\/edits/g).length, 1, 'trying is written down nowhere');
    assert.equal(cellsOf(done.state, 'cyan'), done.cells);
    assert.equal(done.state.origin, 'table');
    const after = await labelsOf(still);
    assert.ok(after.count(CYAN) > 0.2 * width * height, `much of the picture is carpet: ${after.count(CYAN)}`);
    assert.equal(after.at(place.x + 4, place.y + 4), CYAN);

    const again = await edit({ op: 'pick', label: 'cyan', still, ...place, take_away: true });
    assert.ok(again.cells > 0);
    assert.ok((await labelsOf(still)).count(CYAN) < 0.02 * width * height);
    await post('colors/undo');
    assert.equal((await labelsOf(still)).count(CYAN), after.count(CYAN));
    await post('colors/undo');
    assert.equal((await labelsOf(still)).count(CYAN), 0);
    await post('colors/redo');
    assert.equal((await labelsOf(still)).count(CYAN), after.count(CYAN));
    await post('colors/undo');
    await post('colors/undo', undefined, 409);
  });

  it('report each label\'s margin to the carpet, and widen thin ones', async () => {
    const least = (state, label) => Math.min(...state.margins.filter((one) => one.label === label).flatMap(({ brighter, darker }) => [brighter ?? 9, darker ?? 9]));
    const checked = async (wanted) => becomes(async () => {
      const { checks } = await (await fetch(service.address('api/checks'))).json();
      const colors = checks.find(({ id }) => id === 'colors');
      return colors.state === wanted ? colors : null;
    }, `the check of colours does not become ${wanted}`);
    const before = await becomes(async () => {
      const state = await get('colors');
      return state.margins?.length ? state : null;
    }, 'the carpet is not seen');
    assert.ok(before.margins.some(({ label, surface }) => label === 'green' && surface === 'carpet'));
    assert.ok(least(before, 'green') >= before.wanted_margin, JSON.stringify(before.margins));
    await checked('pass');

    // Green just above the carpet: carpet in a quarter more light has this colour.
    const { still, width, height } = await post('stills', undefined, 201);
    const place = `x=${Math.round(width * 0.4)}&y=${Math.round(height * 0.5)}`;
    const { mean } = await get(`pixels?${place}&width=9&height=9&still=${still}`);
    const lit = (light) => mean.map((value, i) => Math.round(i === 0 ? light * value : 128 + light * (value - 128)));
    const paint = { op: 'paint', label: 'green', shape: 'box', at: lit(1.5), radius: [6, 10, 10], over: 'clear' };
    const thin = await edit(paint);
    const margin = least(thin.state, 'green');
    assert.ok(margin > 0.1 && margin < before.wanted_margin, `${margin}`);
    assert.match((await checked('warn')).text, /^Camera 0: carpet becomes green at \+\d+ %$/);
    const { alerts } = await service.statusBecomes(({ alerts: all }) => all.some(({ id }) => id === 'margin_thin'));
    const alert = alerts.find(({ id }) => id === 'margin_thin');
    assert.deepEqual([alert.camera, alert.page, alert.severity], [0, '#/colours/0', 'warn']);

    const painted = await bytes('colors/table');
    const tried = await post('colors/edits', { commands: [{ op: 'widen_margins' }], try: true });
    assert.ok(tried.cells > 0.5 * thin.cells, 'it clears what was painted, up to 1.6 times the light');
    assert.deepEqual(await bytes('colors/table'), painted, 'trying changes nothing');
    const { cells, state } = await edit({ op: 'widen_margins' });
    assert.equal(state.undo.what, 'widened the margins to carpet and floor');
    assert.ok(cells > 0 && least(state, 'green') >= state.wanted_margin, JSON.stringify(state.margins));
    await checked('pass');
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots are not found any more');
    assert.ok(Math.abs(least(await post('colors/undo'), 'green') - margin) < 0.05, 'it is undone cell by cell');

    // With carpet labelled green the check fails, so no match can begin.
    const carpet = await edit({ ...paint, at: lit(1), radius: [30, 12, 12] });
    assert.equal(least(carpet.state, 'green'), 0);
    assert.match((await checked('fail')).text, /carpet is green now/);
    await post('colors/undo');
    await post('colors/undo');
  });

  it('keep the carpet\'s colours when a pick overlaps them', async () => {
    await becomes(async () => (await get('colors')).margins?.length, 'the carpet is not seen');
    const { still, width, height } = await post('stills', undefined, 201);
    const tryPick = (x, y) => post('colors/edits', { commands: [{ op: 'pick', label: 'cyan', still, x, y, width: 3, height: 3 }], try: true });
    const places = Array.from({ length: 60 }, (_, i) => [Math.round(width * (0.02 + (i % 20) * 0.05)), Math.round(height * [0.2, 0.5, 0.8][i % 3])]);
    const carpet = await tryPick(Math.round(width * 0.4), Math.round(height * 0.5));
    assert.ok(carpet.cells > 0);
    assert.equal(carpet.left_to_carpet, 0, 'who points at the carpet means it');
    // The still was taken in full light, so its carpet is brighter than the current carpet: partly within the range,
    // partly beyond it.
    await service.patch({ op: 'replace', path: '/cameras/0/source/light', value: 0.58 });
    await becomes(async () => (await get('colors')).margins?.length, 'the dark carpet is not seen');
    const edge = await becomes(async () => {
      for (const [x, y] of places) {
        const tried = await tryPick(x, y);
        if (!(tried.left_to_carpet > 0 && tried.cells > 0)) continue;
        // The carpet may have been measured again in the meantime.
        const done = await edit({ op: 'pick', label: 'cyan', still, x, y, width: 3, height: 3 });
        await post('colors/undo');
        if (done.left_to_carpet > 0 && done.cells > 0) return done;
      }
    }, 'no pick lies at the end of the range');
    assert.equal(cellsOf(edge.state, 'cyan'), edge.cells, 'what it says is what it does');
    await service.patch({ op: 'replace', path: '/cameras/0/source/light', value: 1 });
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots do not come back');
  });

  it('make detections come and go', async () => {
    await edit({ op: 'remove', label: 'pink' }, { op: 'remove', label: 'green' }, { op: 'remove', label: 'blue' }, { op: 'remove', label: 'yellow' }, { op: 'remove', label: 'orange' });
    await becomes(async () => (await detections()).robots === 0, 'robots are still found without a colour');
    await post('colors/undo');
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots do not come back');
  });

  it('say what lies under the pointer', async () => {
    const { still } = await post('stills', undefined, 201);
    const labels = await labelsOf(still);
    const place = await becomes(async () => {
      for (let y = 10; y < labels.height - 10; ++y) {
        for (let x = 10; x < labels.width - 10; ++x) if (labels.at(x, y) === PINK && labels.at(x + 2, y + 2) === PINK) return { x: x + 1, y: y + 1 };
      }
    }, 'there is no pink');
    const region = await get(`pixels?x=${place.x}&y=${place.y}&region=true&still=${still}`);
    assert.equal(region.shares[0].label, 'pink');
    assert.equal(region.shares[0].share, 1, 'a region has one label');
    assert.ok(region.count >= 9 && region.count < 400, `as large as a dot: ${region.count}`);
    assert.ok(region.mean[2] > 140, 'pink is reddish');
    assert.equal(region.histogram.y.reduce((a, b) => a + b), region.count);
    await get(`pixels?x=${place.x}&y=${place.y}&still=999999`, 404);
    await get('pixels?width=0', 400);
  });

  it('lose no edit when several people make them at once', async () => {
    const places = Array.from({ length: 40 }, (_, i) => [20 + 5 * i, 40, 40]);
    await Promise.all(places.map((at) => edit({ op: 'paint', label: 'cyan', shape: 'box', at, radius: [1, 1, 1] })));
    const state = await get('colors');
    const one = (await post('colors/edits', { commands: [{ op: 'paint', label: 'black', shape: 'box', at: [20, 40, 40], radius: [1, 1, 1] }], try: true })).cells;
    assert.equal(cellsOf(state, 'cyan'), one * places.length);
    const history = await (await fetch(service.address('api/settings/history'))).json();
    assert.ok(history.filter(({ what }) => what === 'colours').length < 20, 'strokes are few steps of the settings');
    assert.equal(history[0].what, 'colours');
  });

  it('outlive the service, and a step of the settings takes them back', async () => {
    const before = await bytes('colors/table');
    await service.stop();
    await service.start();
    assert.deepEqual(await bytes('colors/table'), before);
    assert.equal((await get('colors')).origin, 'table');
    await service.statusBecomes(({ cameras }) => cameras[0].frames > 0);
    const [{ revision }] = await (await fetch(service.address('api/settings/history'))).json();
    const undone = await fetch(service.address('api/settings/undo'), { method: 'POST', body: JSON.stringify({ revision }) });
    assert.equal(undone.status, 200, await undone.text());
    assert.notDeepEqual(await bytes('colors/table'), before);
  });

  it('go back to the settings, and that can be undone', async () => {
    await edit({ op: 'paint', label: 'cyan', shape: 'ball', at: [100, 60, 60], radius: [20, 10, 10] });
    const painted = await bytes('colors/table');
    const state = await post('colors/reset');
    assert.equal(state.origin, 'classes');
    assert.equal(cellsOf(state, 'cyan'), 0);
    await post('colors/reset', undefined, 409);
    await post('colors/undo');
    assert.deepEqual(await bytes('colors/table'), painted);
  });

  it('travel as files and between cameras', async () => {
    const table = await bytes('colors/table');
    const json = await bytes('colors/export?format=json');
    assert.deepEqual(await bytes('colors/export?format=lut'), table);
    await post('colors/reset');
    for (const [file, name] of [[table, 'mine.lut'], [json, 'mine.json']]) {
      const tried = await post(`colors/import?name=${name}&try=true`, file);
      assert.equal(tried.tables.length, 1);
      assert.ok(tried.tables[0].labels.includes('pink'));
      assert.notDeepEqual(await bytes('colors/table'), table);
      const { state } = await post(`colors/import?name=${name}`, file);
      assert.match(state.undo.what, new RegExp(name));
      assert.deepEqual(await bytes('colors/table'), table);
      await post('colors/undo');
    }
    await edit({ op: 'remove', label: 'pink' });
    await post('colors/copy', { from: 1 });
    const other = await (await fetch(service.address('api/cameras/1/colors'))).json();
    assert.equal(cellsOf(await get('colors'), 'pink'), cellsOf(other, 'pink'));
    await post('colors/copy', { from: 0 }, 409);
    await post('colors/copy', { from: 7 }, 404);
    await post('colors/copy', { from: 'x' }, 400);
  });

  it('may be finer or coarser, and robots are found all the same', async () => {
    for (const bits of [6, 8, 7]) {
      await service.patch({ op: 'replace', path: '/cameras/0/colors/bits', value: bits });
      assert.equal((await get('colors')).bits, bits);
      await becomes(async () => (await detections()).robots === pictureRobots, `robots are not found with ${bits} bits`);
      const { cells, state } = await edit({ op: 'paint', label: 'cyan', shape: 'box', at: [60, 40, 40], radius: [8, 8, 8] });
      assert.ok(cells > 0);
      assert.equal(state.bits, bits);
      await edit({ op: 'remove', label: 'cyan' });
    }
  });

  it('may have labels of their own', async () => {
    await service.patch({ op: 'add', path: '/own_labels/-', value: { value: 12, name: 'violet', color: '#8040ff' } });
    const { state } = await edit({ op: 'paint', label: 'violet', shape: 'ball', at: [90, 160, 150], radius: [10, 8, 8] });
    const violet = state.labels.find(({ name }) => name === 'violet');
    assert.deepEqual({ value: violet.value, color: violet.color, built_in: violet.built_in }, { value: 12, color: '#8040ff', built_in: false });
    assert.ok(violet.cells > 0);
    // A label in use cannot be removed: its cells would have no name.
    const answer = await fetch(service.address('api/settings'), { method: 'PATCH', body: JSON.stringify([{ op: 'remove', path: '/own_labels/0' }]) });
    const { error } = await answer.json();
    assert.equal(answer.status, 422, error);
    assert.match(error, /label 12/);
    await edit({ op: 'remove', label: 'violet' });
    await service.patch({ op: 'remove', path: '/own_labels/0' });
  });

  it('are refused with a reason if invalid, and nothing changes', async () => {
    const before = await bytes('colors/table');
    for (const [commands, complaint] of [
      [[{ op: 'paint', label: 'mauve', shape: 'ball', at: [1, 2, 3], radius: [1, 1, 1] }], /\/commands\/0\/label: "mauve" is not allowed; expected/],
      [[{ op: 'paint', label: 'pink', shape: 'ball', at: [1, 2, 300], radius: [1, 1, 1] }], /\/commands\/0\/at/],
      [[{ op: 'fly' }], /\/commands\/0\/op: "fly"/],
      [[{ op: 'remove', label: 'pink' }, { op: 'pick', label: 'pink', x: 9000, y: 0 }], /\/commands\/1: the rectangle/],
      [[{ op: 'grow', label: 'pink', cells: 99 }], /\/commands\/0\/cells: 99/],
      [[], /commands/],
    ]) {
      const { error } = await post('colors/edits', { commands }, 422);
      assert.match(error, complaint);
    }
    const widen = { commands: [{ op: 'widen_margins', label: 'pink' }] };
    assert.match((await post('colors/edits', widen, 422)).error, /\/commands\/0\/label/);
    assert.match((await post('colors/edits', { commands: [{ op: 'pick', label: 'pink', x: 1, y: 1, still: 999999 }] }, 404)).error, /still 999999/);
    const noise = Uint8Array.from({ length: 5000 }, (_, i) => i * 7 % 256);
    for (const [file, complaint] of [
      [new Uint8Array(0), /the file/], [noise, /noise.lut/], [before.slice(0, before.length - 9), /noise.lut/],
      [new TextEncoder().encode('<?xml version="1.0"?><VarXML><List name="x"></List></VarXML>'), /noise.lut/],
      [new TextEncoder().encode('{"format": "ssl-visiond colour table", "version": 1, "bits": 7, "labels": [], "runs": "AAA"}'), /noise.lut/],
    ]) {
      const { error } = await post(`colors/import${file.length ? '?name=noise.lut' : ''}`, file, 422);
      assert.match(error, complaint);
    }
    assert.deepEqual(await bytes('colors/table'), before);
    await get('colors/export?format=bmp', 400);
    assert.equal((await fetch(service.address('api/cameras/9/colors'))).status, 404);
  });

  it('have no margins while no carpet was seen in colour', async () => {
    await service.patch({ op: 'replace', path: '/cameras/0/source/pixel_format', value: 'mono8' });
    await service.statusBecomes(({ cameras }) => cameras[0].pixel_format === 'mono8' && cameras[0].frames > 0);
    await becomes(async () => (await get('colors')).margins === null, 'the margins of before are not forgotten');
    const { error } = await post('colors/edits', { commands: [{ op: 'widen_margins' }] }, 422);
    assert.match(error, /^\/commands\/0: camera 0's carpet has not been seen yet/);
    await service.patch({ op: 'replace', path: '/cameras/0/source/pixel_format', value: 'uyvy' });
    await becomes(async () => (await get('colors')).margins?.length, 'the carpet is not seen again');
  });

  it('survive a damaged file: the camera has its settings\' colours and an alert says so', async () => {
    await edit({ op: 'paint', label: 'cyan', shape: 'ball', at: [100, 70, 60], radius: [20, 10, 10] });
    await service.stop();
    const folder = join(service.folder, 'state/tables');
    for (const file of readdirSync(folder)) writeFileSync(join(folder, file), readFileSync(join(folder, file)).subarray(0, 30));
    await service.start();
    await service.statusBecomes(({ alerts }) => alerts.some(({ id }) => id === 'table_lost'));
    assert.equal(cellsOf(await get('colors'), 'cyan'), 0);
    // The next edit that is saved takes effect and clears the alert.
    await edit({ op: 'paint', label: 'cyan', shape: 'ball', at: [100, 70, 60], radius: [20, 10, 10] });
    await service.statusBecomes(({ alerts }) => !alerts.some(({ id }) => id === 'table_lost'));
  });

  it('are learnt from the live picture, shown, and accepted or not', async () => {
    await edit(...['pink', 'green', 'blue', 'yellow', 'orange', 'cyan'].map((label) => ({ op: 'remove', label })));
    await becomes(async () => (await detections()).robots === 0, 'robots are still found without a colour');
    const empty = await bytes('colors/table');
    const learn = async () => {
      await post('colors/learning', { frames: 3 }, 202);
      return becomes(async () => {
        const state = await get('colors/learning');
        return ['collecting', 'solving'].includes(state.state) ? null : state;
      }, 'learning does not end');
    };
    await post('colors/learning/accept', undefined, 409);
    const { state, report } = await learn();
    assert.equal(state, 'done');
    assert.equal(report.problem, '');
    assert.equal(report.pictures.length, 3);
    for (const picture of report.pictures) {
      assert.equal(picture.before.robots.length, 0);
      assert.equal(picture.after.robots.length, pictureRobots);
      assert.ok(picture.taught.some(({ kind }) => kind === 'robot'));
    }
    assert.deepEqual(await bytes('colors/table'), empty, 'nothing changes before it is accepted');
    assert.equal(new TextDecoder('latin1').decode((await bytes('colors/learning/pictures/0?width=100')).slice(6, 10)), 'JFIF');
    const labels = await bytes('colors/learning/pictures/0?labels=after');
    assert.notDeepEqual(labels, await bytes('colors/learning/pictures/0?labels=before'));
    await get('colors/learning/pictures/3', 404);

    await post('colors/learning/reject');
    assert.equal((await get('colors/learning')).state, 'idle');
    assert.deepEqual(await bytes('colors/table'), empty);

    await learn();
    const accepted = await post('colors/learning/accept');
    assert.match(accepted.undo.what, /^learnt from/);
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots are not found with what was learnt');
    await post('colors/undo');
    assert.deepEqual(await bytes('colors/table'), empty);
    await post('colors/redo');
    assert.equal((await post('colors/learning', { frames: 99 }, 422)).error.startsWith('/frames: 99'), true);
  });

  it('follow the light when they may, step by step, and go back', async () => {
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots are not found');
    const accepted = await bytes('colors/table');
    await service.patch({ op: 'replace', path: '/cameras/0/follow_light/enabled', value: true });
    await becomes(async () => (await get('colors')).light.state === 'following', 'the light is not followed');
    await service.patch({ op: 'replace', path: '/cameras/0/source/light', value: 0.75 });
    const changed = await becomes(async () => {
      const { light } = await get('colors');
      return light.changed && light.gain[1] < 0.85 ? light : null;
    }, 'the table does not follow the light');
    assert.ok(changed.steps.length > 0);
    assert.deepEqual(await bytes('colors/table'), accepted, 'the accepted one stays');
    assert.notDeepEqual(await bytes('colors/table?light=true'), accepted);

    await post('colors/light/revert');
    assert.deepEqual(await bytes('colors/table?light=true'), accepted);
    await post('colors/light/revert', undefined, 409);

    await service.patch({ op: 'replace', path: '/cameras/0/follow_light/enabled', value: false });
    await becomes(async () => (await get('colors')).light.state === 'off', 'the light is still followed');
    await service.patch({ op: 'replace', path: '/cameras/0/source/light', value: 1 });
    await lightIsBack();
    await service.patch({ op: 'replace', path: '/cameras/0/follow_light/enabled', value: true });
    await becomes(async () => (await get('colors')).light.state === 'following', 'the light is not followed again');
    await service.patch({ op: 'replace', path: '/cameras/0/source/light', value: 0.75 });
    await becomes(async () => (await get('colors')).light.changed, 'the table does not follow the light again');
    const kept = await post('colors/light/keep');
    assert.match(kept.undo.what, /light/);
    assert.equal(kept.light.changed, false);
    assert.notDeepEqual(await bytes('colors/table'), accepted);
    await post('colors/undo');
    assert.deepEqual(await bytes('colors/table'), accepted);
    await service.patch({ op: 'replace', path: '/cameras/0/follow_light/enabled', value: false }, { op: 'replace', path: '/cameras/0/source/light', value: 1 });
    // Once the follower notices that it is off, after up to 200 ms, it discards what it learnt in this light.
    await becomes(async () => (await get('colors')).light.state === 'off', 'the light is still followed');
    await lightIsBack();
  });

  it('follow the light only within the limits, and report only documented states', async () => {
    const { enum: allowed } = openApi.components.schemas.LightState.properties.state;
    const seen = new Set();
    const light = async () => {
      const now = (await get('colors')).light;
      seen.add(now.state);
      return now;
    };
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots are not found');
    await service.patch(
      { op: 'replace', path: '/cameras/0/follow_light/max_brightness', value: 1.1 },
      { op: 'replace', path: '/cameras/0/follow_light/enabled', value: true });
    await becomes(async () => (await light()).state === 'following', () => `the light is not followed, but ${[...seen]}`);
    // Beyond the bound, but close enough that robots are still detected: without robots, following is frozen.
    await service.patch({ op: 'replace', path: '/cameras/0/source/light', value: 0.86 });
    const bound = await becomes(async () => {
      const now = await light();
      return now.state === 'at_bound' ? now : null;
    }, 'the light is followed beyond the bound');
    assert.match(bound.reason, /^the brightness differs from the accepted table's by more than a factor 1\.1$/);
    for (const gain of bound.gain) assert.ok(gain > 0.8, `${bound.gain}`);
    await service.patch(
      { op: 'replace', path: '/cameras/0/follow_light/enabled', value: false },
      { op: 'replace', path: '/cameras/0/follow_light/max_brightness', value: 4 },
      { op: 'replace', path: '/cameras/0/source/light', value: 1 });
    await becomes(async () => (await light()).state === 'off', 'the light is still followed');
    await lightIsBack();
    for (const state of seen) assert.ok(allowed.includes(state), `${state} is none of ${allowed}`);
  });

  it('that flood are reported with colour and place, and robots are still found', async () => {
    await service.patch({ op: 'replace', path: '/cameras/0/source/noise_sigma', value: 20 });
    const { still, width, height } = await post('stills', undefined, 201);
    const { mean } = await get(`pixels?x=${Math.round(width * 0.03)}&y=${Math.round(height * 0.5)}&width=9&height=9&still=${still}`);
    // From now on half of the noise on the carpet is labelled green.
    const at = [Math.round(mean[0]) + 40, Math.round(mean[1]), Math.round(mean[2])];
    await edit({ op: 'paint', label: 'green', shape: 'box', at, radius: [40, 60, 60], over: 'clear' });
    const alert = await becomes(async () => {
      const { alerts } = await (await fetch(service.address('api/alerts'))).json();
      return alerts.find(({ id }) => id === 'frames_capped');
    }, 'nobody says that a colour floods');
    assert.match(alert.title, /^Camera 0: green floods the image between \(\d+, \d+\) and \(\d+, \d+\) px/);
    assert.equal(alert.page, '#/colours/0');
    await becomes(async () => (await detections()).robots >= pictureRobots / 2, 'robots are not found');
    await post('colors/undo');
    await service.patch({ op: 'replace', path: '/cameras/0/source/noise_sigma', value: service.settings.cameras[0].source.noise_sigma ?? 2 });
    await becomes(async () => (await detections()).robots === pictureRobots, 'robots are not found again');
  });

  it('are kept small on disk', () => {
    const folder = join(service.folder, 'state/tables');
    const files = readdirSync(folder).filter((name) => name.endsWith('.lut'));
    assert.ok(files.length > 0);
    for (const name of files) assert.ok(statSync(join(folder, name)).size < 300_000, name);
  });
});
