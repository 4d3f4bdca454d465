// SPDX-License-Identifier: Apache-2.0
// The page for annotating an image: clicks become a command, which is then run. The page's script runs here on a stub
// of the few DOM parts that it uses, so no browser is needed.
//   SSLV_LAB  ssl-visionlab; default: the release build's
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, it } from 'node:test';
import { runInNewContext } from 'node:vm';
import { root } from './service.mjs';

const LAB = process.env.SSLV_LAB ?? join(root, 'build/release/bin/ssl-visionlab');
const settings = join(root, 'config/demo.json');
let folder;

before(() => {
  folder = mkdtempSync(join(tmpdir(), "a hall's pictures "));
  execFileSync(LAB, ['simulate', '--settings', settings, '--frames', '1', '--start', '1000', '--output', join(folder, 'hall')]);
  execFileSync(LAB, ['annotate', '--settings', settings, '--input', join(folder, 'hall'), '--truth', join(folder, 'truth.jsonl')]);
});
after(() => rmSync(folder, { recursive: true }));

const truth = () => JSON.parse(readFileSync(join(folder, 'truth.jsonl'), 'utf8'));
const html = () => readFileSync(join(folder, 'truth_pages', 'frame_000000.html'), 'utf8');

/** A stub element with the members that the page uses. */
function element() {
  return {
    attributes: {}, children: [], listeners: {}, style: {}, textContent: '', value: '', isGone: false,
    setAttribute(name, value) { this.attributes[name] = value; },
    append(child) { this.children.push(child); },
    replaceChildren() { this.children = []; },
    addEventListener(name, listener) { (this.listeners[name] ??= []).push(listener); },
    getBoundingClientRect() { return { left: 10, top: 20, width: this.width / 2, height: this.height / 2 }; }, // shown at half its size
    remove() { this.isGone = true; },
    happens(name, event = {}) { for (const listener of this.listeners[name] ?? []) listener(event); },
    all(kind) { return this.children.flatMap((child) => [...(child.kind === kind ? [child] : []), ...child.all(kind)]); },
  };
}

/** Loads the page from disk. */
function load() {
  const page = html();
  const data = /<script type="application\/json" id="data">(.*?)<\/script>/s.exec(page)[1];
  const { width, height } = JSON.parse(data);
  const named = new Map([['data', { ...element(), textContent: data }]]);
  const byId = (name) => {
    if (!named.has(name)) named.set(name, element());
    return named.get(name);
  };
  let what = 'remove';
  runInNewContext(/<script>(.*?)<\/script>/s.exec(page)[1], {
    document: {
      getElementById: byId,
      createElementNS: (space, kind) => Object.assign(element(), { kind, width, height }),
      querySelector: () => ({ value: what }),
    },
  });
  const svg = () => byId('view').children[0];
  return {
    byId,
    svg,
    marks: () => svg().all('g').filter(({ attributes }) => attributes['data-number'] > 0),
    choose: (choice) => { what = choice; },
    press: (name, [x, y]) => svg().happens(name, { clientX: 10 + (x + 0.5) / 2, clientY: 20 + (y + 0.5) / 2 }),
    /** Runs the command that the page shows, as if pasted into a shell. */
    run: () => execFileSync('bash', ['-c', byId('words').value.replace('ssl-visionlab', '"$0"'), LAB]),
  };
}

it('shows a mark with its number for everything that was found', () => {
  const page = load();
  const { robots, balls } = truth();
  assert.ok(robots.length > 2);
  assert.deepEqual(page.marks().map(({ attributes }) => attributes['data-number']), [...robots, ...balls].map(({ number }) => number));
  assert.equal(page.marks()[0].all('text')[0].textContent, `1: ${robots[0].team} ${robots[0].id}`);
  assert.equal(page.svg().all('image')[0].attributes.href.slice(0, 23), 'data:image/jpeg;base64,');
  assert.match(page.byId('state').textContent, /not checked yet/);
  assert.ok(page.byId('next').isGone);
  page.press('pointermove', [100, 50]);
  assert.equal(page.byId('pixel').textContent, 'pixel 100 50');
});

it('makes a command of what is pointed at, and that does it', () => {
  const page = load();
  const [first, second, third] = truth().robots;
  page.marks()[0].happens('click');
  page.choose('doubtful');
  page.marks()[1].happens('click');
  page.choose('id');
  page.byId('id').value = '14';
  page.marks()[2].happens('click');
  page.choose('ball');
  page.press('pointerdown', [50, 60]);
  page.press('pointerup', [50, 60]);
  page.choose('robot');
  page.byId('team').value = first.team;
  page.byId('id').value = String(first.id);
  page.press('pointerdown', [first.pixel_x, first.pixel_y]);
  page.press('pointerup', [first.pixel_x + 20, first.pixel_y]);
  page.run();
  const { robots, balls } = truth();
  assert.equal(robots.find(({ number }) => number === first.number), undefined);
  assert.equal(robots.find(({ number }) => number === second.number).visible_share, 0);
  assert.equal(robots.find(({ number }) => number === third.number).id, 14);
  const added = robots.at(-1);
  assert.deepEqual([added.team, added.id, added.by], [first.team, first.id, 'hand']);
  assert.ok(Math.hypot(added.x - first.x, added.y - first.y) < 1, JSON.stringify([first, added]));
  assert.deepEqual([balls.at(-1).pixel_x, balls.at(-1).pixel_y], [50, 60]);
});

it('undoes the last correction, and shows the command that marks the image as checked', () => {
  const page = load();
  page.marks()[0].happens('click');
  page.byId('undo').happens('click');
  assert.match(page.byId('words').value, /--checked$/);
  page.run();
  assert.equal(truth().checked, true);
  assert.equal(load().byId('state').textContent, 'checked');
});
