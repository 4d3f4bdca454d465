// SPDX-License-Identifier: Apache-2.0
// The panel's settings page: an admin's changes, verified at the service and in its images.
// Environment: see service.mjs and browser.mjs.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { beforeEach, describe, it } from 'node:test';
import { accessibleInThemes, byId, createBrowser, DESKTOP, itLong, PHONE, phone, saved, textBecomes, views } from './browser.mjs';
import { becomes, createService, freeTcpPort } from './service.mjs';

const service = await createService('239.255.77.79');
const { address, patch, statusBecomes } = service;
const { aroundTests, withPage } = createBrowser(service);

const ask = async (path, method = 'GET', body = undefined) => {
  const answer = await fetch(address(`api/${path}`), { method, body: body === undefined ? undefined : JSON.stringify(body) });
  assert.ok(answer.ok, `${method} ${path}: ${answer.status}`);
  return answer.json();
};
const tree = async () => (await ask('settings')).settings;
const row = (pointer) => byId(`setting-${pointer}`);

const treeBecomes = (wanted) => becomes(tree, wanted);

/** Mean brightness of the camera's image, 0 to 255. */
const brightness = (page, camera) => page.evaluate(async (url) => {
  const bitmap = await createImageBitmap(await (await fetch(url)).blob());
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
  return sum / (data.length / 4) / 3;
}, `api/cameras/${camera}/snapshot.jpg`);

const brightnessBecomes = (page, camera, wanted) => becomes(() => brightness(page, camera), wanted);

const typeInto = async (page, pointer, value) => {
  const field = page.locator(`${row(pointer)} input[type="text"]`);
  await field.fill(value);
  await field.press('Enter');
};

describe('settings page', () => {
  let first;
  aroundTests(async () => {
    first = await tree();
  });
  beforeEach(service.restore);

  for (const { name, viewport, options, it } of views) {
    it(`moves a slider and the picture follows, on a ${name}`, withPage(viewport, '#/settings', options, async (page) => {
      // Navigate through the tree, as a user would.
      await page.click(`${byId('place-/cameras/0')}`);
      await page.click(name === 'phone' ? byId('open-/cameras/0/source') : byId('place-/cameras/0/source'));
      const before = await brightness(page, 0);
      assert.ok(before > 50, `${before}`);
      const slider = page.locator(`${row('/cameras/0/source/light')} input[type="range"]`);
      await slider.scrollIntoViewIfNeeded();
      await slider.focus();
      await page.keyboard.press('Home'); // darkest
      await saved(page);
      await treeBecomes(({ cameras }) => cameras[0].source.light < 0.1);
      await brightnessBecomes(page, 0, (now) => now < before / 3);
      assert.ok((await brightness(page, 1)) > before / 2, 'the other camera stays');
      // In the dark nothing is detected.
      await statusBecomes(({ cameras }) => cameras[0].robots === 0 && cameras[1].robots > 0);

      await page.click(`${row('/cameras/0/source/light')} button.reset`);
      await brightnessBecomes(page, 0, (now) => now > before * 0.8);
      await page.waitForSelector(`${row('/cameras/0/source/light')}:not([data-changed])`);
      await treeBecomes(({ cameras }) => cameras[0].source.light === 1);
    }));

    it(`keeps an invalid input and says why, on a ${name}`, withPage(viewport, '#/settings/cameras/0/stages/detect_balls', options, async (page) => {
      const pointer = '/cameras/0/stages/detect_balls/min_confidence';
      await typeInto(page, pointer, '7');
      const error = page.locator(`${row(pointer)} [role="alert"]`);
      assert.match(await error.textContent(), /Must be at most 1.*still uses 0\.5/s);
      assert.equal(await page.inputValue(`${row(pointer)} input[type="text"]`), '7', 'what was typed stays');
      assert.equal((await tree()).cameras[0].stages.detect_balls.min_confidence, 0.5);

      await typeInto(page, pointer, '0.4');
      await error.waitFor({ state: 'detached' });
      await treeBecomes(({ cameras }) => cameras[0].stages.detect_balls.min_confidence === 0.4);
    }));
  }

  it('shows the service\'s refusals', withPage(DESKTOP, '#/settings/network', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs the refusal
    await typeInto(page, '/network/vision/group', 'nowhere');
    const error = await page.waitForSelector(`${row('/network/vision/group')} [role="alert"]`);
    assert.match(await error.textContent(), /\/network\/vision\/group.*nowhere.*still uses 239\.255\.77\.79/s);
    assert.equal((await tree()).network.vision.group, '239.255.77.79');
    assert.equal(await page.inputValue(`${row('/network/referee/interface')} input`), '', 'an empty text is shown as such');
  }));

  it('never overwrites what somebody else saved meanwhile', withPage(DESKTOP, '#/settings/cameras/0/stages/detect_balls', {}, async (page) => {
    const pointer = '/cameras/0/stages/detect_balls/max_balls';
    const value = async () => (await tree()).cameras[0].stages.detect_balls.max_balls;
    const editMeanwhile = async (theirs, mine) => {
      const field = page.locator(`${row(pointer)} input[type="text"]`);
      await field.focus();
      await field.fill(String(mine));
      await patch({ op: 'replace', path: pointer, value: theirs });
      // The page has received that change before Enter is pressed.
      await page.waitForFunction((one) => document.querySelector('[aria-label="History"]')?.textContent.includes(one), `${theirs}`);
      await field.press('Enter');
      const conflict = await page.waitForSelector(`${row(pointer)} .conflict`);
      assert.match(await conflict.textContent(), new RegExp(`changed this.*The saved value is ${theirs}, yours is ${mine}`, 's'));
      assert.equal(await value(), theirs);
    };
    await editMeanwhile(771, 30);
    await page.click(`${row(pointer)} button:has-text("Keep 771")`);
    await page.waitForSelector(`${row(pointer)} .conflict`, { state: 'detached' });
    assert.equal(await page.inputValue(`${row(pointer)} input[type="text"]`), '771');
    assert.equal(await value(), 771);

    await editMeanwhile(772, 31);
    await page.click(`${row(pointer)} button:has-text("Use 31")`);
    await page.waitForSelector(`${row(pointer)} .conflict`, { state: 'detached' });
    await treeBecomes(({ cameras }) => cameras[0].stages.detect_balls.max_balls === 31);
  }));

  it('records one history step for one move of a slider', withPage(DESKTOP, '#/settings/cameras/0/source', {}, async (page) => {
    const pointer = '/cameras/0/source/light';
    const steps = async () => (await ask('settings/history')).length;
    const before = await steps();
    const range = page.locator(`${row(pointer)} input[type="range"]`);
    await range.scrollIntoViewIfNeeded();
    const slider = await range.boundingBox();
    const at = (share) => [slider.x + slider.width * share, slider.y + slider.height / 2];
    await page.mouse.move(...at(0.32));
    await page.mouse.down();
    for (let share = 0.34; share < 0.7; share += 0.04) {
      const last = (await tree()).cameras[0].source.light;
      await page.mouse.move(...at(share));
      await treeBecomes(({ cameras }) => cameras[0].source.light !== last);
    }
    await page.mouse.up();
    await saved(page);
    assert.equal(await steps(), before + 1);
    const [step] = await ask('settings/history');
    assert.deepEqual(step.changes.map(({ path, before: from }) => [path, from]), [[pointer, 1]]);
    await page.keyboard.press('Control+z');
    await treeBecomes(({ cameras }) => cameras[0].source.light === 1);
    await page.waitForSelector(`${byId('notice')}:has-text("undone: camera 0 / source / light")`);

    // Discarding typed text changes nothing.
    const now = await steps();
    const field = page.locator(`${row(pointer)} input[type="text"]`);
    await field.fill('2.5');
    await field.press('Escape');
    assert.equal(await field.inputValue(), '1');
    await typeInto(page, pointer, '1.5');
    await treeBecomes(({ cameras }) => cameras[0].source.light === 1.5);
    assert.equal(await steps(), now + 1);
  }));

  it('stays with a camera whose place in the list another admin changes', withPage(DESKTOP, '#/settings/cameras/1/stages/detect_balls', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs the refusal
    await page.waitForSelector(row('/cameras/1/stages/detect_balls/max_balls'));
    const [gone] = (await tree()).cameras;
    await patch({ op: 'remove', path: '/cameras/0' });
    await page.waitForSelector(row('/cameras/0/stages/detect_balls/max_balls'));
    assert.match(page.url(), /#\/settings\/cameras\/0\/stages\/detect_balls$/);
    await page.waitForSelector('.crumbs:has-text("Camera 1")');
    await page.waitForSelector(`${byId('notice')}:has-text("A camera was added or removed")`);
    // A change made before the page learns of the insertion must not be applied to the camera now in that place.
    let isBack = false;
    await page.route('**/api/settings', async (route) => {
      if (route.request().method() !== 'PATCH' || isBack) return route.continue();
      isBack = true;
      await patch({ op: 'add', path: '/cameras/0', value: gone });
      return route.continue();
    });
    await typeInto(page, '/cameras/0/stages/detect_balls/max_balls', '17');
    await page.waitForSelector(row('/cameras/1/stages/detect_balls/max_balls'));
    assert.deepEqual((await tree()).cameras.map(({ stages }) => stages.detect_balls.max_balls), first.cameras.map(({ stages }) => stages.detect_balls.max_balls));

    // Undo must not revert a change to one camera on another camera.
    await patch({ op: 'replace', path: '/cameras/1/stages/detect_balls/max_balls', value: 21 });
    const [{ revision }] = await ask('settings/history');
    await patch({ op: 'replace', path: '/cameras/0/stages/detect_balls/max_balls', value: 21 });
    await patch({ op: 'add', path: '/cameras/0', value: { ...gone, id: 7 } });
    const undone = await fetch(address('api/settings/undo'), { method: 'POST', body: JSON.stringify({ revision }) });
    assert.equal(undone.status, 409);
  }));

  it('checks a stack before it is applied', withPage(DESKTOP, '#/settings/cameras/0/stack', {}, async (page, panel) => {
    const stack = async () => (await tree()).cameras[0].stack;
    const orderBecomes = (wanted) => page.waitForFunction(([selector, names]) => [...document.querySelectorAll(selector)].map((name) => name.textContent).join() === names,
      [`${byId('stack')} > li b`, wanted.join()]);
    const applied = () => page.waitForSelector(byId('stack-check'), { state: 'detached' });
    await textBecomes(page, 'stage-segment', /\d\sµs|\d\sms/);

    panel.errorsExpected = true; // the browser logs the refusal
    await page.click(`${byId('stage-segment')} button[aria-label="Remove segment"]`);
    const error = await page.waitForSelector(`${byId('stage-detect_robots')} ${byId('stage-error')}`);
    assert.match(await error.textContent(), /stage 'detect_robots' needs 'regions', which no earlier stage provides/);
    assert.ok(await page.isDisabled(byId('stack-apply')));
    assert.deepEqual(await stack(), first.cameras[0].stack, 'nothing is applied');
    await page.click(byId('stack-discard'));
    await page.waitForSelector(byId('stage-error'), { state: 'detached' });
    await orderBecomes(first.cameras[0].stack);

    // Switched off and on, and moved by keyboard.
    await page.click(`${byId('stage-publish')} [role="switch"]`);
    await page.waitForSelector(`${byId('stack-check')}[data-state="fine"]`);
    assert.equal((await stack()).length, 4);
    await page.click(byId('stack-apply'));
    await applied();
    assert.deepEqual(await stack(), ['segment', 'detect_robots', 'detect_balls']);
    await statusBecomes(({ cameras }) => cameras[0].stages.length === 3);
    await page.waitForSelector(`${byId('stage-publish')}.off`);
    await page.click(`${byId('stage-publish')} [role="switch"]`);
    await page.focus(`${byId('stage-publish')} .grip`);
    await page.keyboard.press('ArrowUp');
    await page.waitForFunction((selector) => document.querySelector(selector)?.dataset.index === '2', byId('stage-publish'));
    assert.equal(await page.evaluate(() => document.activeElement.closest('li').dataset.testid), 'stage-publish', 'the handle keeps the focus');
    const needs = await page.waitForSelector(`${byId('stage-publish')} ${byId('stage-error')}`);
    assert.match(await needs.textContent(), /stage 'publish' needs 'balls'/);
    await page.keyboard.press('ArrowDown');
    await page.waitForSelector(`${byId('stack-check')}[data-state="fine"]`);
    await page.click(byId('stack-apply'));
    await applied();
    assert.deepEqual(await stack(), first.cameras[0].stack);

    // Dragged with the mouse, and stages replaced.
    const from = await page.locator(`${byId('stage-publish')} .grip`).boundingBox();
    const to = await page.locator(`${byId('stage-detect_balls')} .grip`).boundingBox();
    await page.mouse.move(from.x + from.width / 2, from.y + from.height / 2);
    await page.mouse.down();
    await page.mouse.move(to.x + to.width / 2, to.y + to.height / 2, { steps: 5 });
    await page.mouse.up();
    await orderBecomes(['segment', 'detect_robots', 'publish', 'detect_balls']);
    await page.click(byId('stack-discard'));
    await orderBecomes(first.cameras[0].stack);
    await page.click(byId('add-stage'));
    await page.click(byId('add-find_runs'));
    await orderBecomes(['segment', 'detect_robots', 'detect_balls', 'find_runs', 'publish']);
    await page.click(byId('stack-discard'));
  }));

  it('keeps what is rearranged while a stack is being saved', withPage(DESKTOP, '#/settings/cameras/0/stack', {}, async (page) => {
    let answer;
    const mayAnswer = new Promise((resolve) => { answer = resolve; });
    await page.route('**/api/settings', async (route) => {
      if (route.request().method() !== 'PATCH') return route.continue();
      const response = await route.fetch();
      await mayAnswer;
      await route.fulfill({ response });
    });
    await page.click(`${byId('stage-publish')} [role="switch"]`);
    await page.waitForSelector(`${byId('stack-check')}[data-state="fine"]`);
    await page.click(byId('stack-apply'));
    await treeBecomes(({ cameras }) => cameras[0].stack.length === 3);
    await page.click(`${byId('stage-detect_balls')} [role="switch"]`);
    answer();
    await saved(page);
    await page.waitForSelector(`${byId('stack-check')}[data-state="fine"]`);
    for (const [name, isOn] of [['segment', true], ['detect_robots', true], ['detect_balls', false], ['publish', false]])
      await page.waitForSelector(`${byId(`stage-${name}`)}${isOn ? ':not(.off)' : '.off'}`);
    await page.click(byId('stack-apply'));
    await treeBecomes(({ cameras }) => cameras[0].stack.join() === 'segment,detect_robots');
    await page.unrouteAll({ behavior: 'wait' });
  }));

  it('undoes steps from the history', withPage(DESKTOP, '#/settings/cameras/1/stages/detect_robots', {}, async (page) => {
    const pointer = '/cameras/1/stages/detect_robots/max_rms_mm';
    await typeInto(page, pointer, '5');
    await treeBecomes(({ cameras }) => cameras[1].stages.detect_robots.max_rms_mm === 5);
    const { revision } = await ask('settings');
    const step = await page.waitForSelector(byId(`step-${revision}`));
    assert.match(await step.textContent(), /camera 1 \/ detect_robots \/ max_rms_mm.*6.*5 mm/s);
    await page.click(`${byId(`step-${revision}`)} button[aria-label^="Undo the step"]`);
    await treeBecomes(({ cameras }) => cameras[1].stages.detect_robots.max_rms_mm === 6);
    await page.waitForFunction((selector) => document.querySelector(selector)?.value === '6', `${row(pointer)} input[type="text"]`);
  }));

  it('undoes the user\'s last change with Ctrl+Z', withPage(DESKTOP, '#/settings/cameras/1/stages/detect_robots', {}, async (page) => {
    const pointer = '/cameras/1/stages/detect_robots/max_rms_mm';
    const value = async () => (await tree()).cameras[1].stages.detect_robots.max_rms_mm;
    const slider = `${row(pointer)} input[type="range"]`;
    await page.focus(slider);
    await page.keyboard.press('Home');
    await treeBecomes(({ cameras }) => cameras[1].stages.detect_robots.max_rms_mm === 0.5);
    await page.waitForSelector(`${byId('undo-last')}:not([disabled])`);
    await page.focus(byId('settings-search'));
    await page.keyboard.press('Control+z'); // a text field has its own undo
    await page.focus(slider);
    assert.equal(await value(), 0.5);
    await page.keyboard.press('Control+z');
    await treeBecomes(({ cameras }) => cameras[1].stages.detect_robots.max_rms_mm === 6);
    await page.waitForSelector(`${byId('notice')}:has-text("undone")`);
  }));

  it('finds settings, and those that are changed', withPage(DESKTOP, '#/settings', {}, async (page) => {
    await page.waitForSelector(byId('place-title'));
    await page.keyboard.press('/');
    await page.keyboard.type('camera 1 min_confidence');
    await page.waitForFunction((selector) => document.querySelector(selector)?.textContent.startsWith('3 '), byId('results'));
    for (const part of ['stages/detect_robots', 'stages/detect_balls', 'follow_light']) await page.waitForSelector(row(`/cameras/1/${part}/min_confidence`));
    await typeInto(page, '/cameras/1/stages/detect_balls/min_confidence', '0.45'); // settings can be edited in the search results
    await treeBecomes(({ cameras }) => cameras[1].stages.detect_balls.min_confidence === 0.45);
    await saved(page);
    await page.fill(byId('settings-search'), 'no such thing');
    await page.waitForSelector('text=No setting has all these words');
    await page.fill(byId('settings-search'), '');

    const count = Number(await page.textContent(`${byId('changed-only')} .count`));
    await page.click(byId('changed-only'));
    await page.waitForSelector(`${row('/cameras/1/stages/detect_balls/min_confidence')}[data-changed]`);
    await textBecomes(page, 'results', new RegExp(`^${count} `));
    assert.equal(await page.locator(row('/cameras/1/stages/detect_robots/min_confidence')).count(), 0);
    await page.click(`${row('/cameras/1/stages/detect_balls/min_confidence')} button.reset`);
    await page.waitForSelector(row('/cameras/1/stages/detect_balls/min_confidence'), { state: 'detached' });
    assert.equal(Number(await page.textContent(`${byId('changed-only')} .count`)), count - 1);
  }));

  it('adds, duplicates and removes cameras, colours and controls, with a way back', withPage(DESKTOP, '#/settings/cameras', {}, async (page) => {
    await page.click(byId('add-simulator'));
    await treeBecomes(({ cameras }) => cameras.length === 3 && cameras[2].id === 2 && cameras[2].source.backend === 'simulator');
    await page.click('button[aria-label="Remove camera 2"]');
    await treeBecomes(({ cameras }) => cameras.length === 2);
    await page.waitForSelector(`${byId('notice')}:has-text("Camera 2 removed")`); // not the notice about adding it
    await page.click(byId('notice-undo'));
    await treeBecomes(({ cameras }) => cameras.length === 3);
    await page.waitForSelector(`${byId('camera-entry')}:has-text("Camera 2")`);

    await page.goto(address('#/settings/cameras/0/colors/classes'));
    // Waits after each click until the list shows its result.
    const listIs = async (labels) => {
      await treeBecomes(({ cameras }) => cameras[0].colors.classes.map(({ label }) => label).join() === labels);
      await page.waitForFunction(([selector, wanted]) => [...document.querySelectorAll(selector)].map((title) => title.textContent).join() === wanted, [`${byId('entry')} .title b`, labels]);
    };
    await page.click('button[aria-label="Duplicate green"]');
    await listIs('orange,yellow,blue,pink,green,green');
    await page.click('button[aria-label="Move orange down"]');
    await listIs('yellow,orange,blue,pink,green,green');
    await page.click('button[aria-label="Remove yellow"]');
    await listIs('orange,blue,pink,green,green');
    assert.deepEqual((await tree()).cameras[0].colors.classes[0], first.cameras[0].colors.classes[0]);

    await page.goto(address('#/settings/ball_models'));
    await page.click(`${byId('switch-/ball_models')} [role="switch"]`);
    await treeBecomes(({ ball_models }) => ball_models === null);
    await saved(page);
    await page.click(`${byId('switch-/ball_models')} [role="switch"]`);
    await treeBecomes(({ ball_models }) => ball_models?.acc_roll === -0.45);

    await patch({ op: 'replace', path: '/cameras/2/source', value: { backend: 'files', path: service.folder } });
    await page.goto(address('#/settings/cameras/2/source/controls'));
    await page.fill(byId('pair-name'), 'paused');
    await page.fill(byId('pair-value'), 'true');
    await page.click(byId('pair-add'));
    await treeBecomes(({ cameras }) => cameras[2].source.controls.paused === true);
    await page.click('button[aria-label="Remove paused"]');
    await treeBecomes(({ cameras }) => !('paused' in cameras[2].source.controls));
  }));

  it('saves, shows, applies and deletes profiles', withPage(DESKTOP, '#/settings/~profiles', {}, async (page, panel) => {
    panel.errorsExpected = true; // the browser logs the refusal
    await page.fill(byId('profile-name'), 'Evening');
    await page.click(byId('profile-save'));
    await page.waitForSelector(byId('profile-Evening'));
    await patch({ op: 'replace', path: '/site', value: 'Hall 3' }, { op: 'replace', path: '/cameras/1/calibration/tx', value: 77 });
    await page.click(`${byId('profile-Evening')} button:has-text("Review and apply")`);
    assert.match(await page.textContent(byId('section-/site')), /site.*Hall 3.*Demo field/s);
    assert.equal(await page.isChecked(`${byId('section-/cameras/1/calibration')} input`), false);
    await page.click(byId('apply-changes'));
    const now = await treeBecomes(({ site }) => site === 'Demo field');
    assert.equal(now.cameras[1].calibration.tx, 77, 'calibrations stay unless ticked');
    await page.waitForSelector(byId('changes'), { state: 'detached' });

    // Exactly what was reviewed is applied, or nothing, even if the page already knows of later changes.
    await patch({ op: 'replace', path: '/site', value: 'Hall 4' });
    await page.click(`${byId('profile-Evening')} button:has-text("Review and apply")`);
    await page.waitForSelector(byId('section-/site'));
    await patch({ op: 'replace', path: '/site', value: 'Hall 5' });
    await page.waitForFunction(() => document.querySelector('[aria-label="History"]')?.textContent.includes('Hall 5'));
    await page.click(byId('apply-changes'));
    await page.waitForSelector('[role="alert"]:has-text("Nothing was applied. Check the changes again.")');
    assert.equal((await tree()).site, 'Hall 5');
    await page.waitForSelector(`${byId('section-/site')}:has-text("Hall 5")`);
    await page.click(byId('apply-changes'));
    await treeBecomes(({ site }) => site === 'Demo field');
    await page.waitForSelector(byId('changes'), { state: 'detached' });

    await page.click(`${byId('profile-Evening')} button:has-text("Review and apply")`);
    await page.check(`${byId('section-/cameras/1/calibration')} input`);
    await page.click(byId('apply-changes'));
    await treeBecomes(({ cameras }) => cameras[1].calibration.tx === first.cameras[1].calibration.tx);
    await page.waitForSelector(byId('changes'), { state: 'detached' });

    await page.click('button[aria-label="Delete profile Evening"]');
    await page.waitForSelector(byId('profile-Evening'), { state: 'detached' });
    assert.deepEqual((await ask('profiles')).profiles, []);
    await page.waitForSelector(`${byId('notice')}:has-text("Profile Evening deleted")`);
    await page.click(byId('notice-undo'));
    await page.waitForSelector(byId('profile-Evening'));
    assert.deepEqual((await ask('profiles/Evening')).settings, first);
    await ask('profiles/Evening', 'DELETE');
  }));

  for (const { name, viewport, options, it } of views) {
    it(`exports and imports the whole tree, on a ${name}`, withPage(viewport, '#/settings/~profiles', options, async (page, panel) => {
      const [download] = await Promise.all([page.waitForEvent('download'), page.click(byId('export'))]);
      assert.match(download.suggestedFilename(), /^ssl-visiond-Demo-field-\d{8}-\d{4}\.json$/);
      const file = readFileSync(await download.path());
      const { version } = await (await fetch(service.address('api/settings'))).json();
      assert.deepEqual(JSON.parse(file), { version, ...first });

      await patch({ op: 'replace', path: '/site', value: 'Elsewhere' }, { op: 'replace', path: '/cameras/0/stack', value: ['segment'] });
      const give = (text) => page.setInputFiles(byId('import'), { name: 'all.json', mimeType: 'application/json', buffer: Buffer.from(text) });
      await page.waitForFunction(() => document.querySelector('.top')?.textContent.includes('Elsewhere'));
      await give(file);
      await page.waitForSelector(byId('changes'));
      assert.match(await page.textContent(byId('changes')), /Elsewhere.*Demo field.*stack/s);
      await page.uncheck(`${byId('section-/site')} input`);
      await page.click(byId('apply-changes'));
      const now = await treeBecomes(({ cameras }) => cameras[0].stack.length === 4);
      assert.equal(now.site, 'Elsewhere', 'what is not ticked stays');
      await page.waitForSelector(byId('changes'), { state: 'detached' });
      await give(file);
      await page.waitForSelector(byId('changes'));
      await page.click(byId('apply-changes'));
      assert.deepEqual(await treeBecomes(({ site }) => site === 'Demo field'), first);
      await page.waitForSelector(byId('changes'), { state: 'detached' });

      panel.errorsExpected = true; // the browser logs the refusal
      for (const [broken, what] of [['{"site":', /all\.json is not valid JSON/], ['[]', /expected an object/], [JSON.stringify({ ...first, sight: 1 }), /all\.json: .*\/sight: no such parameter/]]) {
        await give(broken);
        await page.waitForFunction(([selector, pattern]) => new RegExp(pattern).test(document.querySelector(selector)?.textContent ?? ''), [byId('import-error'), what.source]);
        assert.equal(await page.locator(byId('changes')).count(), 0);
      }
      assert.deepEqual(await tree(), first);
    }));
  }

  for (const { name, viewport, options, it } of views) {
    it(`saves a backup and restores it, on a ${name}`, withPage(viewport, '#/settings/~profiles', options, async (page, panel) => {
      const edit = (at) => ask('cameras/0/colors/edits', 'POST', { commands: [{ op: 'paint', label: 'pink', shape: 'box', at, radius: [1, 1, 1] }] });
      await ask('profiles/Kept', 'PUT', {});
      await edit([20, 40, 40]);
      const kept = await tree();
      assert.match(kept.cameras[0].colors.table, /^[0-9a-f]{16}$/);
      const [download] = await Promise.all([page.waitForEvent('download'), page.click(byId('backup'))]);
      assert.match(download.suggestedFilename(), /^Demo-field-\d{8}-\d{6}\.sslvision$/);
      const buffer = readFileSync(await download.path());
      const [secret] = await Promise.all([page.waitForEvent('download'), page.check(byId('backup-passwords')).then(() => page.click(byId('backup')))]);
      assert.match(secret.url(), /^blob:/);

      await ask('profiles/Kept', 'DELETE');
      await edit([30, 60, 60]);
      await patch({ op: 'replace', path: '/site', value: 'Elsewhere' });
      const before = await tree();
      const give = (bytes) => page.setInputFiles(byId('restore'), { name: 'hall.sslvision', mimeType: 'application/gzip', buffer: bytes });
      await give(buffer);
      await page.waitForSelector(byId('backup-contents'));
      const contents = await page.textContent(byId('backup-contents'));
      for (const held of [/hall\.sslvision/, /Site\s*Demo field/, /Cameras\s*0 \(-x half\), 1 \(\+x half\)/, /Colour tables\s*\d/, /Profiles\s*Kept/, /Passwords\s*none/, /Made\s*\d\d:\d\d:\d\d/]) assert.match(contents, held);
      assert.deepEqual(await tree(), before, 'nothing changes before it is restored');
      await accessibleInThemes(page, `a backup on a ${name}`);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));

      await page.click(byId('restore-now'));
      await page.waitForSelector(byId('backup-contents'), { state: 'detached' });
      assert.deepEqual(await tree(), kept);
      await page.waitForSelector(byId('profile-Kept'));
      await page.click(`${byId('notice')} button:has-text("Undo")`);
      assert.deepEqual(await treeBecomes(({ site }) => site === 'Elsewhere'), before);

      panel.errorsExpected = true; // the browser logs the refusal
      const damaged = Buffer.from(buffer);
      damaged[buffer.length >> 1] ^= 0x10;
      for (const [bytes, what] of [[Buffer.from('{}'), /^hall\.sslvision: this is not a complete backup: /], [damaged, /^hall\.sslvision: /], [buffer.subarray(0, buffer.length - 9), /^hall\.sslvision: /]]) {
        await give(bytes);
        await page.waitForFunction(([selector, pattern]) => new RegExp(pattern).test(document.querySelector(selector)?.textContent ?? ''), [byId('backup-error'), what.source]);
        assert.equal(await page.locator(byId('backup-contents')).count(), 0);
      }
      assert.deepEqual(await tree(), before);
      await ask('profiles/Kept', 'DELETE');
    }));
  }

  it('leads through one column on a phone', withPage(PHONE, '#/settings', phone, async (page) => {
    await page.waitForSelector(byId('settings-search'));
    assert.equal(await page.isVisible(byId('place-title')), false, 'the tree first');
    await page.click(byId('place-/teams'));
    await page.waitForSelector(row('/teams/yellow/name'));
    assert.equal(await page.isVisible(byId('settings-search')), false);
    await page.click('a:has-text("All settings")');
    await page.waitForSelector(byId('settings-search'));
    await page.fill(byId('settings-search'), 'loopback');
    await page.waitForSelector(row('/network/vision/loopback'));
    assert.equal(await page.isVisible('a:has-text("History")'), false, 'only the results show');
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  }));

  const looks = [
    { name: 'General', path: '#/settings/~general', ready: row('/site') },
    { name: 'a stage', path: '#/settings/cameras/0/stages/detect_balls', ready: byId('stack') },
    { name: 'the stack', path: '#/settings/cameras/0/stack', ready: byId('add-stage') },
    { name: 'cameras', path: '#/settings/cameras', ready: byId('camera-entry') },
    { name: 'a source', path: '#/settings/cameras/0/source', ready: byId('backend') },
    { name: 'colours', path: '#/settings/cameras/0/colors/classes', ready: byId('entry') },
    { name: 'profiles', path: '#/settings/~profiles', ready: byId('profile-name') },
    { name: 'history', path: '#/settings/~history', ready: '.inline' },
    { name: 'tree', path: '#/settings', ready: byId('settings-search') },
  ];
  for (const { name: view, viewport, options } of views) {
    itLong(`is accessible on a ${view}`, withPage(viewport, '', options, async (page) => {
      for (const { name, path, ready } of looks) {
        await page.goto(address(path));
        await page.waitForSelector(ready);
        if (name === 'colours') await page.click(`${byId('entry')} .title`);
        await accessibleInThemes(page, `${name} on a ${view}`);
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name} is no wider than a ${view}`);
        if (view === 'desktop') assert.ok(await page.evaluate(() => document.documentElement.scrollHeight <= innerHeight), `${name} fits a ${view}`);
      }
    }));
  }

  // The last test: the port stays.
  it('follows the panel to another port', withPage(DESKTOP, '#/settings/panel', {}, async (page, panel) => {
    panel.errorsExpected = true; // the old port closes
    const old = address('');
    const port = service.settings.panel.port = await freeTcpPort();
    await typeInto(page, '/panel/port', String(port));
    await page.waitForURL((url) => url.port === String(port));
    await page.waitForSelector(row('/panel/port'));
    panel.strangers = panel.strangers.filter((url) => !url.startsWith(old));
  }));
});
