// SPDX-License-Identifier: Apache-2.0
// Checks that layout.mjs detects faults: a correct page with one fault added at a time.
import assert from 'node:assert/strict';
import { after, before, describe, it } from 'node:test';
import { axeFaults, launch } from './browser.mjs';
import { layoutFaults } from './layout.mjs';

const SIZE = { width: 360, height: 640 };

const sound = ({ style = '', body = '' } = {}) => `<!doctype html><html lang="en"><head><title>A page</title><style>
  * { box-sizing: border-box; }
  body { margin: 0; font: 16px sans-serif; color: #000; background: #fff; }
  main { padding: 12px; }
  .row { display: flex; flex-wrap: wrap; gap: 10px; }
  .btn { height: 48px; padding: 0 14px; border-radius: 7px; }
  .card { border: 1px solid #888; overflow: hidden; padding: 8px; margin-top: 12px; }
  .list { height: 150px; overflow: auto; }
  .picture { position: relative; height: 240px; margin-top: 12px; }
  canvas { width: 320px; height: 240px; display: block; background: #060; }
  .on { position: absolute; left: 8px; top: 8px; color: #fff; background: #000; }
  .name { max-width: 120px; overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
  .vh { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); white-space: nowrap; }
  ${style}
</style></head><body><main>
  <h1>A page</h1>
  <div class="row"><button class="btn" id="one">One</button><button class="btn" id="two">Two</button><label class="btn">Three <input type="checkbox"></label></div>
  <div class="card" id="card"><p id="text">All of this text can be read, on as many lines as it needs.</p></div>
  <div class="card list" tabindex="0" role="group" aria-label="List"><p style="height: 400px">Much of it is below</p><p id="below">and can be scrolled to. <a href="#one" id="inline">See</a></p></div>
  <p class="name" title="A long name that is told in full by its title">A long name that is told in full by its title</p>
  <span class="vh">For ears only, however long it may be</span>
  <div class="picture"><canvas data-testid="camera-picture-0" role="img" aria-label="Image" width="320" height="240"></canvas><span class="on">Camera 0</span></div>
  ${body}
</main></body></html>`;

/** One fault each: what it adds to the page, and the expected message and element. */
const faults = [
  { name: 'a page that scrolls sideways', body: '<div style="width: 500px">wide</div>', kind: 'wide', at: /document/ },
  { name: 'a text that its box cuts sideways', style: '#text { white-space: nowrap; }', kind: 'cut', at: /p.*All of this text/ },
  { name: 'a text that its box cuts in height', style: '#card { height: 24px; }', kind: 'cut', at: /p.*All of this text/ },
  { name: 'a shortened name without a title', body: '<p class="name">Nobody can know how this name goes on</p>', kind: 'cut', at: /Nobody can know/ },
  { name: 'a control that its box cuts', body: '<div class="card" style="width: 80px"><button class="btn" style="width: 150px">Redo</button></div>', kind: 'cut', at: /Redo/ },
  { name: 'a control beyond the left edge', style: '#one { position: absolute; left: -60px; }', kind: 'outside', at: /One/ },
  { name: 'a control that stands below the window', style: '#one { position: fixed; top: 630px; }', kind: 'outside', at: /One/ },
  { name: 'a choice wider than its field', body: '<label class="row">Much <select style="width: 70px; height: 48px"><option>A very long choice</option></select></label>', kind: 'cut', at: /select/ },
  { name: 'a slot too low to scroll in', style: '.list { height: 40px; }', kind: 'cut', at: /List/ },
  { name: 'two texts on top of each other', body: '<p>One text of this page</p><p style="margin-top: -30px">Another text of it</p>', kind: 'overlap', at: /nother text|One text/ },
  { name: 'a text that something lies on', body: '<p style="position: relative">Twelve thousand cells<span style="position: absolute; left: 90px; top: 0; width: 60px; background: #fd0">!!!</span></p>', kind: 'overlap', at: /Twelve/ },
  { name: 'two controls on top of each other', style: '#two { margin-left: -40px; }', kind: 'overlap', at: /One|Two/ },
  { name: 'a control that something covers', body: '<div style="position: absolute; left: 0; top: 60px; width: 100%; height: 80px; background: #ccc"></div>', kind: 'overlap', at: /One|Two|Three/ },
  { name: 'the end of a page under a bar that stands still', body: '<button class="btn">Last</button><nav style="position: fixed; inset: auto 0 0 0; height: 70px; background: #ccc">Bar</nav>', kind: 'overlap', at: /Last/ },
  { name: 'a target too small for a finger', style: '#one { height: 30px; }', kind: 'small', at: /One/ },
  { name: 'an image too small to use', style: 'canvas { width: 120px; height: 90px; }', kind: 'image', at: /camera-picture-0/ },
  { name: 'an image that its box cuts', style: '.picture { overflow: hidden; height: 150px; }', kind: 'image', at: /camera-picture-0/ },
  { name: 'an image larger than the window', style: 'canvas { height: 900px; } .picture { height: auto; }', kind: 'image', at: /camera-picture-0/ },
];

describe('the layout check', () => {
  let browser;
  let page;
  before(async () => {
    browser = await launch();
    page = await (await browser.newContext({ viewport: SIZE, hasTouch: true })).newPage();
  });
  after(() => browser?.close());

  async function see(parts, meant) {
    await page.setContent(sound(parts));
    return layoutFaults(page, { isTouch: true, meant });
  }

  it('finds nothing wrong with a sound page', async () => {
    assert.deepEqual(await see(), []);
    assert.deepEqual(await axeFaults(page), []);
  });

  for (const { name, kind, at, ...parts } of faults) {
    it(`finds ${name}`, async () => {
      const found = await see(parts);
      assert.ok(found.some((fault) => fault.kind === kind && at.test(fault.at)), `${kind} is not among ${JSON.stringify(found, null, 2)}`);
    });
  }

  it('accepts only marked exceptions', async () => {
    const parts = { style: '#one { height: 30px; } #two { height: 30px; }' };
    const found = await see(parts, [{ kind: 'small', selector: '#one', why: 'a test' }]);
    assert.deepEqual(found.map(({ kind, at }) => [kind, /Two/.test(at)]), [['small', true]]);
  });

  it('lets two links of one sentence wrap', async () => {
    for (let width = 120; width <= 320; width += 20) {
      const found = await see({ body: `<p style="width: ${width}px">Read <a href="#one">the whole first description</a> or <a href="#two">the second one</a>.</p>` });
      assert.deepEqual(found, [], `${width} px`);
    }
  });

  it('lets a menu that a button opened cover what is below', async () => {
    const look = (isOpen) => see({ body: `<button class="btn" aria-expanded="${isOpen}" aria-controls="menu">Menu</button>
      <div id="menu" style="position: absolute; top: 60px; left: 0; width: 300px; height: 120px; background: #fff"><button class="btn">Choice</button></div>` });
    const overlaps = (found) => found.filter(({ kind }) => kind === 'overlap');
    assert.deepEqual(overlaps(await look(true)), []);
    assert.notDeepEqual(overlaps(await look(false)), []);
  });

  it('reports low contrast through axe', async () => {
    await page.setContent(sound({ style: '#text { color: #ccc; }' }));
    assert.match((await axeFaults(page)).join(), /color-contrast/);
  });
});
