// SPDX-License-Identifier: Apache-2.0
// The page Diagnostics with the real service: it must show what the API returns.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import { beforeEach, describe, it } from 'node:test';
import { accessible, accessibleInThemes, byId, comesUp, createBrowser, DESKTOP, itLong, PHONE, phone, text, textBecomes, views } from './browser.mjs';
import { becomes, createService, eventually } from './service.mjs';

const service = await createService('239.255.77.85');
const { settings, folder, address, patch } = service;
const { aroundTests, withPage } = createBrowser(service);
const PATH = '#/diagnostics';

const ask = async (path) => (await fetch(address(`api/${path}`))).json();

/** Polls the timeline until `wanted` is satisfied. */
const timelineBecomes = (wanted) => becomes(() => ask('timeline?seconds=600'), wanted, ({ time_s, cameras }) => JSON.stringify({
  seconds: time_s.length, newest: time_s.slice(-6), cameras: cameras.map(({ id, fps, robots }) => ({ id, fps: fps.slice(-6), robots: robots.slice(-6) })),
}));
const camera = (timeline, id) => timeline.cameras.find((one) => one.id === id);

/** Index of the sample at that time; -1 if there is none. */
const sampleAt = ({ time_s }, time) => time_s.findIndex((one) => Math.abs(one - time) < 0.002);
/** Whether the service missed that second, as on a busy machine: the page then shows no values for it. */
const isHole = ({ time_s, interval_s }, time) =>
  time_s.some((one, i) => Math.abs(one + interval_s - time) < 0.002 && time_s[i + 1] - one > 1.9 * interval_s);

/** The page's texts for a camera's values at a sample. */
function expectedValues(timeline, id, at) {
  if (at < 0) return { latency: '–', fps: '–', seen: '–', lost: '–' };
  const { latency_p50_ms, latency_p99_ms, fps, robots, balls, dropped, incomplete } = camera(timeline, id);
  const ms = (value) => (value === null ? '–' : value < 9.995 ? value.toFixed(2) : value < 99.95 ? value.toFixed(1) : value.toFixed(0));
  const pair = (a, b, write) => (a === null && b === null ? '–' : `${write(a)} / ${write(b)}`);
  return {
    latency: pair(latency_p50_ms[at], latency_p99_ms[at], ms), fps: fps[at]?.toFixed(1) ?? '–',
    seen: pair(robots[at], balls[at], String), lost: pair(dropped[at], incomplete[at], String),
  };
}

/** The values above the graphs and their time, read in one task. */
const shownValues = (page, ids) => page.evaluate(([list, tipSelector]) => {
  const values = Object.fromEntries(list.map((id) => [id, Object.fromEntries(['latency', 'fps', 'seen', 'lost'].map((graph) =>
    [graph, document.querySelector(`[data-testid="value-${graph}-${id}"]`).lastChild.textContent.trim()]))]));
  return { values, time: Date.parse(document.querySelector(`${tipSelector} time`)?.dateTime) / 1000 };
}, [ids, byId('tip')]);

const ids = settings.cameras.map(({ id }) => id);

/** Compares the values at the cursor with the API; returns the cursor's time. */
async function compareAtCursor(page) {
  const { values, time } = await shownValues(page, ids);
  const timeline = await ask('timeline?seconds=600');
  const at = sampleAt(timeline, time);
  assert.ok(at >= 0 || isHole(timeline, time), `${time} is none of ${timeline.time_s}`);
  for (const id of ids) assert.deepEqual(values[id], expectedValues(timeline, id, at), `camera ${id} at ${time}`);
  return time;
}

/** Waits until all cameras have run for some seconds and the page shows it. */
async function drawn(page) {
  await timelineBecomes(({ time_s, cameras }) => time_s.length > 8 && cameras.every(({ fps }) => fps.slice(-5).every((value) => value !== null)));
  for (const id of ids) await textBecomes(page, `value-fps-${id}`, /\d$/);
}

/** Moves the cursor to the page's newest second, by keyboard. */
async function toNewest(page) {
  await page.focus(byId('graphs'));
  await page.keyboard.press('End');
  await page.waitForSelector(byId('tip'));
}
/** Waits until the page has that second; the cursor is then on its newest one. */
const pageReaches = (page, wanted) => becomes(async () => {
  await toNewest(page);
  return (await shownValues(page, ids)).time;
}, (newest) => newest > wanted - 0.002);

/** Colours of the cameras' curves in the dark theme. */
const CURVES = [[0x8a, 0xb4, 0xff], [0xf2, 0x9b, 0xd4]];

/**
 * Measures a graph's pixels and its cursor; runs in the browser, in one task, so that both belong together. `columns`:
 * the pixel columns of the last six seconds before the cursor, with their distance from the right edge and the heights
 * of the curves above the zero line.
 */
function measureGraph([name, curves]) {
  const graph = document.querySelector(`[data-testid="graph-${name}"]`);
  const canvas = graph.querySelector('canvas');
  const [whole, plane, cursor] = [canvas, graph.querySelector('.u-over'), graph.querySelector('.u-cursor-x')].map((element) => element.getBoundingClientRect());
  const scale = canvas.width / whole.width;
  const [left, top, width, height] = [plane.left - whole.left, plane.top - whole.top, plane.width, plane.height].map((length) => Math.round(length * scale));
  const column = (x) => canvas.getContext('2d').getImageData(left + x, top, 1, height).data;
  const isCurve = (r, g, b, a) => a > 200 && curves.some((colour) => Math.hypot(r - colour[0], g - colour[1], b - colour[2]) < 40);
  const perSecond = width / 60; // the plot shows one minute
  const cursorX = ((cursor.right - plane.left) / plane.width) * width;
  const columns = [];
  for (let x = Math.ceil(cursorX - 6 * perSecond); x < cursorX; x++) {
    const data = column(x);
    const rows = [];
    for (let y = 0; y < height; y++) if (isCurve(...data.subarray(4 * y, 4 * y + 4))) rows.push(height - y - 0.5);
    columns.push({ fromRight_s: (width - x - 0.5) / perSecond, rows });
  }
  const time = Date.parse(document.querySelector('[data-testid="tip"] time')?.dateTime) / 1000; // NaN: the cursor is outside the graph
  // Share of the column half a second before the cursor that has the second camera's shade.
  const second = column(Math.round(cursorX - 0.5 * perSecond));
  let shaded = 0;
  for (let y = 0; y < height; y++) {
    const [r, g, b, a] = second.subarray(4 * y, 4 * y + 4);
    if (a > 20 && a < 100 && r > b && b > g) shaded++;
  }
  return { columns, time, scale, perSecond, cursorFromRight_s: (width - cursorX) / perSecond, shade: shaded / height };
}

/** Near a step the width of the lines interferes: on a phone a second is ten pixels wide. */
const MARGIN_S = 0.38;

/** Checks that the counts of robots and balls in some seconds are drawn to scale. */
async function assertSeenDrawnToScale(page) {
  await page.click('button:has-text("1 min")');
  // Uses only seconds of normal length: shorter ones leave nothing between their steps, longer ones contain a hole.
  // Both happen on a busy machine.
  const whole = (time_s, at) => [at - 3, at - 2, at - 1, at].filter((i) => time_s[i] - time_s[i - 1] > 0.9 && time_s[i] - time_s[i - 1] < 1.9);
  const { measured: { columns, scale }, timeline, at, curves } = await becomes(async () => {
    await toNewest(page);
    await page.keyboard.press('ArrowLeft');
    const measured = await page.evaluate(measureGraph, ['seen', CURVES]);
    const timeline = await ask('timeline?seconds=600');
    const at = sampleAt(timeline, measured.time);
    return { measured, timeline, at, curves: ids.flatMap((id) => [camera(timeline, id).robots, camera(timeline, id).balls]) };
  }, ({ measured: { time, scale, perSecond, cursorFromRight_s }, timeline: { time_s }, at, curves }) => at > 4 && at + 1 < time_s.length
    && whole(time_s, at).length > 1
    && [at - 3, at - 2, at - 1, at].every((i) => curves.every((curve) => curve[i] !== null) && curves.some((curve) => curve[i] > 0))
    // The right edge is the newest second, one after the cursor's; the cursor is at whole CSS pixels.
    && Math.abs(time_s[at + 1] - time - cursorFromRight_s) * perSecond < 2 * scale,
  ({ measured: { time, cursorFromRight_s }, timeline: { time_s }, at, curves }) =>
    JSON.stringify({ time, cursorFromRight_s, at, newest: time_s.slice(-6), curves: curves.map((curve) => curve.slice(-6)) }));
  const right = timeline.time_s[at + 1];
  // A sample covers the time since the previous one; the steps are at its ends.
  const seconds = whole(timeline.time_s, at).map((i) => ({
    counts: curves.map((curve) => curve[i]),
    columns: columns.filter(({ fromRight_s }) => right - fromRight_s > timeline.time_s[i - 1] + MARGIN_S && right - fromRight_s < timeline.time_s[i] - MARGIN_S),
  }));
  const rows = seconds.flatMap((second) => second.columns.flatMap((column) => column.rows));
  assert.ok(rows.length > 0, 'nothing is drawn');
  const highest = rows.filter((row) => row > Math.max(...rows) - 3 * scale);
  const perCount = highest.reduce((sum, row) => sum + row, 0) / highest.length / Math.max(...seconds.flatMap(({ counts }) => counts));
  assert.ok(perCount > 3 * scale, `${perCount} px for one`);
  const isAt = (row, count) => Math.abs(row - count * perCount) < 2.5 * scale;
  const told = JSON.stringify({ perCount, seconds });
  for (const second of seconds) {
    const strays = second.columns.flatMap((column) => column.rows).filter((row) => !second.counts.some((count) => isAt(row, count)));
    assert.deepEqual(strays, [], told);
  }
  // The zero line coincides with the edge of the plot. Balls are dashed, so all columns of the four seconds are searched:
  // the gaps may be a second apart.
  const lately = columns.filter(({ fromRight_s }) => right - fromRight_s > timeline.time_s[at - 4] && right - fromRight_s < timeline.time_s[at]);
  for (const curve of curves) {
    const count = curve[at];
    if (count > 0 && [at - 3, at - 2, at - 1].every((i) => curve[i] === count))
      assert.ok(lately.some((column) => column.rows.some((row) => isAt(row, count))), `${count}: ${told}`);
  }
}

const shownLines = (page) => page.$$eval(byId('log-line'), (lines) => lines.map((line) => ({ level: line.dataset.level, text: line.lastElementChild.textContent })));
const lineIs = (page, words) => page.waitForSelector(`${byId('log-line')}:has-text(${JSON.stringify(words)})`);

describe('panel: Diagnostics', () => {
  aroundTests();
  beforeEach(service.restore);

  for (const { name, viewport, options, it } of views) {
    it(`draws what the timeline says on a ${name}`, withPage(viewport, PATH, options, async (page) => {
      await drawn(page);
      await assertSeenDrawnToScale(page);
      const times = [];
      await toNewest(page);
      for (const key of ['End', 'ArrowLeft', 'ArrowLeft']) {
        await page.keyboard.press(key);
        times.push(await compareAtCursor(page));
      }
      assert.ok(times[0] > times[1] && times[1] > times[2], `the cursor goes back: ${times}`);
      await page.keyboard.press('Escape');
      await page.waitForSelector(byId('tip'), { state: 'detached' });

      // It updates automatically.
      const newest = (await ask('timeline?seconds=1')).time_s[0];
      await pageReaches(page, newest + 1.5);
      await compareAtCursor(page);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} px too wide`);
    }));

    it(`tells of the computer, stages and transport on a ${name}`, withPage(viewport, PATH, options, async (page) => {
      await page.waitForSelector(byId('stage-histogram'));
      // The page polls once a second and marks nothing as outdated, so retry.
      await eventually(async () => {
        const { system, clock, cameras } = await ask('diagnostics');
        const computer = await text(page, 'computer');
        assert.ok(computer.includes(system.host), computer);
        assert.ok(system.cpu_percent.length > 0);
        assert.equal(await page.locator(`${byId('computer')} .cores li`).count(), system.cpu_percent.length);
        assert.match(computer, /Memory.*\d [GM]B of .*\d GB.*This service.*\d % of a core.*\d threads/s);
        assert.match(await text(page, 'clock'), clock === null ? /cannot be read/ : clock.synchronised ? /Error.*±/s : /not synchronised/);
        assert.equal(await page.locator(byId('stage-histogram')).count(), cameras[0].stages.length + 1);
        for (const shape of await page.$$eval(`${byId('stage-histogram')} .shape`, (paths) => paths.map((path) => path.getBoundingClientRect().height)))
          assert.ok(shape > 10, `a histogram ${shape} px high`);
      });
      await eventually(async () => {
        const transport = await page.$$eval(`${byId('transport')} tbody tr`, (rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent)));
        const status = await ask('status');
        assert.deepEqual(transport.map((cells) => cells.slice(1, 5)), status.cameras.map((one) =>
          [one.packets ? String(one.packets.missing) : '–', one.packets ? String(one.packets.resent) : '–', String(one.frames_incomplete), String(one.reconnects)]));
      });
    }));
  }

  it('moves one cursor through all graphs with the pointer', withPage(DESKTOP, PATH, {}, async (page) => {
    await drawn(page);
    await page.click('button:has-text("1 min")');
    const plane = await page.locator(`${byId('graph-latency')} .u-over`).boundingBox();
    await page.mouse.move(plane.x + plane.width - 20, plane.y + 30);
    await page.waitForSelector(byId('tip'));
    await compareAtCursor(page);
    const places = await page.$$eval('.u-cursor-x', (lines) => lines.map((line) => line.getBoundingClientRect().left));
    assert.equal(places.length, 4);
    assert.ok(Math.max(...places) - Math.min(...places) < 0.01, `cursors at ${places}`);
    await page.mouse.move(5, 5);
    await page.waitForSelector(byId('tip'), { state: 'detached' });
  }));

  it('moves the cursor with a finger', withPage(PHONE, PATH, phone, async (page) => {
    await drawn(page);
    await page.click('button:has-text("1 min")');
    const plane = await page.locator(`${byId('graph-fps')} .u-over`).boundingBox();
    await page.touchscreen.tap(plane.x + plane.width - 10, plane.y + 20);
    await page.waitForSelector(byId('tip'));
    await compareAtCursor(page);
  }));

  it('follows the log, pauses, searches and copies', withPage(DESKTOP, PATH, {}, async (page) => {
    await page.context().grantPermissions(['clipboard-read']);
    await patch({ op: 'replace', path: '/site', value: 'Field of the log' });
    await lineIs(page, 'Field of the log');

    await page.click(byId('log-pause'));
    await patch({ op: 'replace', path: '/site', value: 'Field of the pause' });
    await page.waitForSelector('section:has-text("paused, "):has-text(" new line")'); // one or more, as the service may log something else
    assert.ok(!(await shownLines(page)).some((line) => line.text.includes('Field of the pause')));
    await page.click(byId('log-pause'));
    await lineIs(page, 'Field of the pause');

    await page.fill(byId('log-search'), 'FIELD saved');
    const found = await shownLines(page);
    const { lines } = await ask('log');
    const expected = lines.filter((line) => /field/i.test(line.text) && /saved/i.test(line.text)).map((line) => line.text);
    assert.ok(expected.length >= 2);
    assert.deepEqual(found.map((line) => line.text), expected.reverse(), 'newest on top');
    await comesUp(page, 'section', new RegExp(`${found.length} lines copied`), () => page.click(byId('log-copy')));
    const copied = (await page.evaluate(() => navigator.clipboard.readText())).trimEnd().split('\n');
    assert.equal(copied.length, found.length);
    copied.reverse().forEach((line, i) => {
      assert.ok(line.endsWith(`info    ${found[i].text}`), line);
      assert.match(line, /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z /);
    });
  }));

  for (const { name, viewport, options, it } of views) {
    it(`shows the gap and the reason when a camera is lost, on a ${name}`, withPage(viewport, PATH, options, async (page) => {
      await drawn(page);
      const missing = join(folder, `no-such-recording-${name}`);
      await patch({ op: 'replace', path: '/cameras/1/source', value: { backend: 'files', path: missing } });
      const { time_s } = await timelineBecomes((timeline) => camera(timeline, 1).fps.slice(-4).every((value) => value === null));
      // Both in one check: a page that receives nothing for a while has no values of any camera.
      await page.waitForFunction((selectors) => {
        const [other, lost] = selectors.map((selector) => document.querySelector(selector)?.lastChild.textContent.trim());
        return lost === '–' && /\d$/.test(other ?? '');
      }, ids.map((id) => byId(`value-fps-${id}`)));
      await page.waitForSelector(byId('shaded'));
      await lineIs(page, missing);

      await page.click('button:has-text("1 min")');
      await pageReaches(page, time_s.at(-1));
      // A hole is a second in which neither camera ran.
      await becomes(async () => {
        await toNewest(page);
        await page.keyboard.press('ArrowLeft');
        return text(page, 'tip');
      }, (tip) => tip.includes('Camera 1 was not running') && !tip.includes('Camera 0 was'));
      await compareAtCursor(page);
      // Apart from the other camera's curves, the only colour is camera 1's shade.
      const { shade } = await page.evaluate(measureGraph, ['latency', CURVES]);
      assert.ok(shade > 0.6, `${shade} of a second is shaded`);

      await page.click(byId('level-warning'));
      await page.waitForSelector(`${byId('log-line')}[data-level="info"]`, { state: 'detached' });
      await lineIs(page, missing);
      const shown = await shownLines(page);
      const { lines } = await ask('log?level=warning'); // may contain newer lines
      assert.deepEqual(shown.map((line) => line.text).reverse(), lines.slice(0, shown.length).map((line) => line.text));
      assert.ok(shown.every(({ level }) => level === 'warning' || level === 'error'));
      await page.click(byId('level-info'));
      await page.waitForSelector(`${byId('log-line')}[data-level="info"]`);

      await patch({ op: 'replace', path: '/cameras/1/source', value: settings.cameras[1].source });
      await textBecomes(page, 'value-fps-1', /\d$/);
      await page.waitForSelector(byId('shaded'));
    }));
  }

  for (const { name, viewport, options, it } of views) {
    it(`tells what was wrong and what was done, on a ${name}`, withPage(viewport, '#/overview', options, async (page) => {
      const missing = join(folder, `no-such-film-${name}`);
      await patch({ op: 'replace', path: '/cameras/1/source', value: { backend: 'files', path: missing } });
      const lost = `${byId('event')}[data-kind="camera_lost"]:has-text(${JSON.stringify(missing)})`;
      await page.waitForSelector(`${byId('alert')}[data-kind="camera_lost"]`);
      await page.click(byId('alert-history'));
      await page.waitForSelector(`${lost}[data-open="true"]:has-text(" so far")`);
      await page.waitForFunction((selector) => {
        const { top, bottom } = document.querySelector(selector).getBoundingClientRect();
        return top >= 0 && top < innerHeight && bottom > 0;
      }, byId('events'));

      await patch({ op: 'replace', path: '/cameras/1/source', value: settings.cameras[1].source });
      await page.waitForSelector(`${lost}[data-open="false"]`);
      await page.waitForSelector(`${byId('event')}[data-kind="settings_changed"]:has-text("/cameras/1/source"):has-text("by 127.0.0.1")`);
      await page.waitForSelector(`${byId('event')}[data-kind="camera_reopened"]`);
      // It shows what the API returns, in the browser's time zone.
      await eventually(async () => {
        const { entries } = await ask('events');
        const shown = await page.$$eval(byId('event'), (rows) => rows.map((row) => [row.dataset.kind, row.querySelector('time').textContent, row.querySelector('time').dateTime]));
        assert.deepEqual(shown, entries.map(({ id, begin }) => {
          const at = new Date(begin * 1000);
          const two = (value) => String(value).padStart(2, '0');
          return [id, `${two(at.getHours())}:${two(at.getMinutes())}:${two(Math.floor(begin) % 60)}`, at.toISOString()];
        }));
      });
      await page.click(byId('events-bad'));
      await page.waitForSelector(`${byId('event')}[data-severity="info"]`, { state: 'detached' });
      await page.waitForSelector(lost);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(wide <= 0, `the page is ${wide} px too wide`);
      await accessible(page, 'the history');
      if (process.env.SSLV_SHOTS) {
        await page.click(byId('events-all'));
        await page.locator(byId('events')).scrollIntoViewIfNeeded();
        await page.screenshot({ path: `${process.env.SSLV_SHOTS}/events-${name}.png` });
      }
    }));
  }

  it('saves a support bundle', withPage(DESKTOP, PATH, {}, async (page) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(byId('support'))]);
    assert.match(download.suggestedFilename(), /^ssl-visiond-.*\.tar\.gz$/);
    const files = execFileSync('tar', ['tzf', await download.path()], { encoding: 'utf8' }).split('\n');
    for (const file of ['README.txt', 'status.json', 'settings.json', 'settings_history.json', 'log.txt', 'events.json', 'timeline.json', 'camera_1/picture.jpg'])
      assert.ok(files.some((path) => path.endsWith(`/${file}`)), `${file} in ${files}`);
    await page.waitForSelector(`${byId('support')}:enabled`);
  }));

  it('saves a support bundle with a clip, and says whom that shows', withPage(DESKTOP, PATH, {}, async (page, panel) => {
    assert.equal(await page.locator(byId('support-clip')).count(), 0, 'there is none to choose');
    await becomes(() => ask('recordings/clips'), ({ last_seconds }) => last_seconds.cameras.length > 0 && last_seconds.cameras.every(({ seconds }) => seconds >= 0.5));
    const kept = await fetch(address('api/recordings/clips'), { method: 'POST', body: JSON.stringify({ seconds: 0.5, name: 'for a report' }) });
    assert.equal(kept.status, 202);
    const { clips: [{ name }] } = await becomes(() => ask('recordings/clips'), ({ clips }) => clips.some(({ begin_s }) => begin_s !== null));
    await page.reload();
    const choice = page.locator(`${byId('support-clip')} select`);
    assert.match(await choice.locator('option').nth(1).textContent(), /^\d{4}-\d\d-\d\d \d\d:\d\d for a report \(\d.* MB\)$/);
    assert.equal(await page.locator(byId('support-people')).count(), 0);
    await choice.selectOption(name);
    assert.match(await text(page, 'support-people'), /shows the people/);
    await accessible(page, 'a support bundle with a clip');
    if (process.env.SSLV_SHOTS) await page.locator(byId('support-clip')).screenshot({ path: `${process.env.SSLV_SHOTS}/support-clip.png` });
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(byId('support'))]);
    assert.match(download.suggestedFilename(), /^ssl-visiond-.*\.tar$/);
    const files = execFileSync('tar', ['tf', await download.path()], { encoding: 'utf8' }).trim().split('\n');
    assert.ok(files.at(-1).endsWith(`/${name}`), files.join());
    assert.equal((await fetch(address(`api/recordings/clips/${name}`), { method: 'DELETE' })).status, 200);
    panel.errorsExpected = true; // the browser logs the refusal
    await page.click(byId('support'));
    await page.waitForSelector('[role="alert"]:has-text("there is no such clip")');
    await page.waitForSelector(byId('support-clip'), { state: 'detached' });
  }));

  for (const { name, viewport, options } of views) {
    itLong(`is accessible on a ${name}`, withPage(viewport, PATH, options, async (page) => {
      await drawn(page);
      await page.waitForSelector(byId('stage-histogram'));
      await accessibleInThemes(page, `Diagnostics on a ${name}`);
    }));
  }

  itLong('says that the service is gone, and goes on when it is back', withPage(DESKTOP, PATH, {}, async (page, panel) => {
    await drawn(page);
    panel.errorsExpected = true;
    await service.stop();
    await page.waitForSelector('p.trouble:has-text("No answer from the service")');
    await textBecomes(page, 'value-fps-0', /–$/);
    await service.start();
    await page.waitForSelector('p.trouble', { state: 'detached' });
    await drawn(page);
    panel.errorsExpected = false;
    await patch({ op: 'replace', path: '/site', value: 'Field after the restart' });
    await lineIs(page, 'Field after the restart');
  }));
});
