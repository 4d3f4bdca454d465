// SPDX-License-Identifier: Apache-2.0
// Makes a sheet of screenshots of each page at all screen sizes: docs/images/sheets, and docs/screens.md, which shows
// them. Also makes docs/images/overview.jpg, for README.
//   node tests/figures/sheets.mjs [PAGE...]    all pages, or only those whose address begins with a PAGE
// Environment: see tests/e2e/service.mjs and browser.mjs.
import { mkdirSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { chooseTheme, createBrowser, DESKTOP, live, launch, phone } from '../e2e/browser.mjs';
import { becomes, createService, root } from '../e2e/service.mjs';
import { goTo, nameOfSize, pageNames, serviceWith, settled, sizes } from '../e2e/walk.mjs';
import { readSums, sumOf, sumsFile } from '../images.mjs';

const MOST_BYTES = 200_000;
const CAMERAS = 4;
const folder = join(root, 'docs/images/sheets');

/** Views in addition to the router's pages, reached by their links and switches. */
const besides = [
  { path: 'overview', cameras: 0 }, { path: 'camera', cameras: 0 }, { path: 'overview', cameras: 1 }, { path: 'overview', cameras: 2 }, { path: 'overview', cameras: 8 }, { path: 'camera', cameras: 8 },
  { path: 'calibration', press: 'mode-together' }, { path: 'calibration', press: 'mode-masks' },
  { path: 'colours', press: 'show-light' }, { path: 'colours', press: 'show-margins' },
  { path: 'settings/~profiles' }, { path: 'settings/~history' }, { path: 'settings/cameras' }, { path: 'settings/cameras/0' },
  { path: 'settings/cameras/0/stack' }, { path: 'settings/cameras/0/stages/detect_robots' }, { path: 'field/network' }, { path: 'field/packets' },
  { path: 'recordings', cameras: 1 }, { path: 'recordings/clips' }, { path: 'recordings/clips', cameras: 1 },
];
const wanted = process.argv.slice(2);
const views = [...pageNames().map((path) => ({ path })), ...besides]
  .map((view) => ({ cameras: CAMERAS, ...view }))
  .map((view) => ({ ...view, name: [view.path.replace(/\W+/g, '-'), view.press, view.cameras === CAMERAS ? '' : `${view.cameras}-cameras`].filter(Boolean).join('-') }));
const all = views.filter(({ name }) => !wanted.length || wanted.some((start) => name.startsWith(start)));

/** Makes a log and a clip for the recordings pages; returns the clip's name. */
async function record(service) {
  const ask = async (path, body) => (await fetch(service.address(`api/recordings${path}`), body && { method: 'POST', body: JSON.stringify(body) })).json();
  await ask('/match-log', { record: true, name: 'warm-up' });
  await becomes(() => ask('/clips'), ({ last_seconds: { cameras } }) => cameras.length > 0 && cameras.every(({ seconds }) => seconds > 5));
  await ask('/clips', { seconds: 5, name: 'a robot is lost' });
  const { clips: [{ name }] } = await becomes(() => ask('/clips'), ({ clip, clips: [first] }) => clip.state === 'idle' && first?.begin_s);
  await ask('/match-log', { record: false });
  await becomes(() => ask(''), ({ logs: [log] }) => log.seconds !== null);
  return name;
}
async function showClip(page, name) {
  await goTo(page, `recordings/clips/${encodeURIComponent(name)}`);
  await page.waitForSelector('[data-testid="played-picture"][data-place]');
}

/** Combines several screenshots at the same scale, each with its size below. JPEG, compressed to the size limit. */
async function sheet(browser, shots) {
  const context = await browser.newContext({ viewport: { width: 1800, height: 800 } });
  const page = await context.newPage();
  const figures = shots.map(({ size, image }) => `<figure style="width: ${size.width * 0.46}px"><img src="data:image/png;base64,${image.toString('base64')}"><figcaption>${nameOfSize(size)}</figcaption></figure>`);
  await page.setContent(`<style>body { margin: 0; padding: 12px; background: #777; display: flex; flex-wrap: wrap; gap: 12px; align-items: flex-start; font: 13px sans-serif; color: #fff; }
    figure { margin: 0; } img { width: 100%; display: block; }</style>${figures.join('')}`);
  await page.waitForFunction(() => [...document.images].every((image) => image.complete));
  try {
    for (let quality = 80; ; quality -= 8) {
      const image = await page.screenshot({ type: 'jpeg', quality, fullPage: true });
      if (image.length <= MOST_BYTES || quality <= 24) return image;
    }
  } finally {
    await context.close();
  }
}

/** The landing page with the demo's two cameras, for README. Waits half a minute, until the graphs have data. */
async function overview() {
  const service = await createService('239.255.77.129');
  for (const { source } of service.settings.cameras) source.frame_rate_hz = 30;
  const { openPage, open, close } = createBrowser(service, { hz: 30 });
  await open();
  try {
    const { page } = await openPage(DESKTOP);
    await page.goto(service.address(''));
    await live(page);
    await chooseTheme(page, 'dark');
    const { uptime_s } = await service.statusBecomes(() => true);
    await service.statusBecomes((status) => status.uptime_s > uptime_s + 30);
    await settled(page);
    return await page.screenshot({ type: 'jpeg', quality: 88 });
  } finally {
    await close();
  }
}

const browser = await launch();
const shots = new Map(all.map(({ name }) => [name, []]));
for (const count of [...new Set(all.map(({ cameras }) => cameras))]) {
  const service = await serviceWith(count, `239.255.77.${130 + count}`);
  const { openPage, open, close } = createBrowser(service, { webgl: true });
  await open();
  try {
    await service.statusBecomes(({ cameras }) => cameras.every(({ state }) => state === 'running'));
    const clip = all.some(({ cameras, path }) => cameras === count && path.startsWith('recordings')) ? await record(service) : '';
    for (const [n, size] of sizes.entries()) {
      const { width, height, isPhone } = size;
      const { page } = await openPage({ width, height }, isPhone ? phone : {});
      await page.goto(service.address(''));
      await live(page);
      await chooseTheme(page, n % 2 ? 'light' : 'dark');
      for (const view of all.filter(({ cameras }) => cameras === count)) {
        await goTo(page, '');
        if (view.path === 'recordings/clips') await showClip(page, clip);
        else await goTo(page, view.path);
        if (view.press) await page.click(`[data-testid="${view.press}"]`);
        await page.evaluate(() => scrollTo(0, 0));
        await settled(page);
        shots.get(view.name).push({ size, image: await page.screenshot() });
      }
      await page.context().close();
    }
  } finally {
    await close();
  }
}

mkdirSync(folder, { recursive: true });
if (!wanted.length) for (const file of readdirSync(folder)) rmSync(join(folder, file));
for (const { name } of all) {
  const image = await sheet(browser, shots.get(name));
  writeFileSync(join(folder, `${name}.jpg`), image);
  console.log(`${name}.jpg ${image.length} bytes`);
}
if (all.some(({ name }) => name === 'overview')) writeFileSync(join(root, 'docs/images/overview.jpg'), await overview());
await browser.close();
const isMade = (page) => views.filter(({ path }) => path.split('/')[0] === page).every((view) => all.includes(view));
writeFileSync(sumsFile, `${JSON.stringify({ ...readSums(), ...Object.fromEntries(pageNames().filter(isMade).map((page) => [page, sumOf(page)])) }, null, 1)}\n`);

const title = ({ path, press, cameras }) => `${[path, press?.replace(/^(mode|show)-/, '')].filter(Boolean).join(', ')}${cameras === CAMERAS ? '' : `, ${cameras || 'no'} camera${cameras === 1 ? '' : 's'}`}`;
const everything = views.filter(({ name }) => readdirSync(folder).includes(`${name}.jpg`));
writeFileSync(join(root, 'docs/screens.md'), `# Every page at every size of screen
Sizes: ${sizes.map(nameOfSize).join(', ')}. The pages show ${CAMERAS} simulated cameras
unless the title says otherwise. \`./run sheets\` makes these images and this page.

${everything.map((view) => `## ${title(view)}\n![${title(view)}](images/sheets/${view.name}.jpg)\n`).join('\n')}`);
