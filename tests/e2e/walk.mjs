// SPDX-License-Identifier: Apache-2.0
// Visits the whole panel: every page of webui/src/router.ts, every address that these link to, and everything that
// their switches, tabs, steps and menus show. New pages are found automatically.
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { gameController } from './league_messages.mjs';
import { createService, freeUdpPort, root } from './service.mjs';

export const sizes = [
  { width: 1366, height: 650 }, { width: 1280, height: 720 }, { width: 1024, height: 768 },
  { width: 768, height: 1024 }, { width: 800, height: 360, isPhone: true }, { width: 360, height: 780, isPhone: true },
];
export const cameraCounts = [1, 2, 4, 8];
export const nameOfSize = ({ width, height }) => `${width}x${height}`;

/** Pages whose links only scroll: these links are not followed. */
const SCROLLED = new Set(['api', 'diagnostics']);

/** Controls that show something else on the same page. Buttons that change settings are in a ChangeArea. */
const SWITCHES = [
  '.seg button[aria-pressed="false"]', 'button[aria-expanded="false"]', '[role="tab"][aria-selected="false"]',
  '[data-testid^="step-"]:not([aria-current])', 'details:not([open]) > summary',
].map((selector) => `${selector}:not(:disabled):not(.change-area *)`);
const DIALOGS = ['button[aria-haspopup="dialog"]:not(:disabled)'];
/** Elements around every page, such as menus and dialogs, are checked on the first page only. */
const switchesOf = (path) => (path === pageNames()[0] ? [...SWITCHES, ...DIALOGS] : SWITCHES.map((selector) => `main ${selector}`)).join(', ');

/** Names of all pages in the router; the first is the landing page. */
export function pageNames() {
  const source = readFileSync(join(root, 'webui/src/router.ts'), 'utf8');
  const [, list] = /export const pages[^=]*=\s*\[([\s\S]*?)\n\];/.exec(source);
  return [...list.matchAll(/\bname: '([^']+)'/g)].map(([, name]) => name);
}

/** Calibrated cameras with small images over the demo's field, in one or two rows. */
function camerasOver(count, [model]) {
  const HEIGHT_MM = 4000;
  const columns = count > 2 ? count / 2 : count;
  const rows = count > 2 ? 2 : 1;
  const [long, short] = [390, 290];
  // With two or eight cameras the images are across the field, as real halves and eighths are; the panel rotates them.
  const isAcross = count === 2 || count === 8;
  const [along, across] = isAcross ? [short, long] : [long, short];
  const focal = HEIGHT_MM / (1.1 * Math.max(9000 / columns / along, 6000 / rows / across));
  return Array.from({ length: count }, (_, id) => {
    const x = ((id % columns) + 0.5) * (9000 / columns) - 4500;
    const y = (Math.floor(id / columns) + 0.5) * (6000 / rows) - 3000;
    const turn = isAcross ? { q0: Math.SQRT1_2, q1: -Math.SQRT1_2, q2: 0, q3: 0, tx: y, ty: x } : { q0: 1, q1: 0, q2: 0, q3: 0, tx: -x, ty: y };
    return {
      ...structuredClone(model), id, name: `${['near', 'far'][Math.floor(id / columns)]} ${(id % columns) + 1}`,
      source: { ...model.source, width: long, height: short, frame_rate_hz: 4, seed: 1 },
      calibration: {
        ...turn, focal_length: focal, principal_point_x: long / 2, principal_point_y: short / 2, distortion: 0.05, tz: HEIGHT_MM,
        pixel_image_width: long, pixel_image_height: short,
      },
    };
  });
}

/** A service with `count` simulated cameras, at a frame rate that leaves processors to the browser. */
export async function serviceWith(count, group) {
  const service = await createService(group);
  service.settings.cameras = camerasOver(count, service.settings.cameras);
  return service;
}

/** A match that locks the settings, for a service that has not started. Returns a function that ends it. */
export async function matchFor(service) {
  const port = await freeUdpPort();
  const group = '224.5.23.103';
  service.settings.network.referee = { enabled: true, group, port, interface: 'lo' };
  const socket = createSocket('udp4').bind(0, '127.0.0.1');
  await once(socket, 'listening');
  socket.setMulticastInterface('127.0.0.1');
  const timeLeft = Buffer.from([0x18, 0x80, 0xc9, 0xfe, 0x3d]); // 65 s
  const said = Buffer.concat([gameController({ yellow: ['RoboTeam Twente'], blue: ['TIGERs Mannheim'], stage: 1, command: 2 }), timeLeft]);
  const timer = setInterval(() => socket.send(said, port, group), 200);
  return () => {
    clearInterval(timer);
    socket.close();
  };
}

/** Waits until everything on the page has loaded and been drawn. */
export async function settled(page) {
  await page.waitForFunction(() => {
    const main = document.querySelector('main');
    if (!main?.firstElementChild || !document.querySelector('h1') || /(^|\n)\s*(Connecting|Loading)\b/.test(main.innerText)) return false;
    return [...main.querySelectorAll('canvas[data-testid^="camera-picture-"]')]
      .every((canvas) => canvas.dataset.frame || canvas.parentElement.getBoundingClientRect().width === 0);
  });
  await page.evaluate(async () => {
    await document.fonts.ready;
    for (let i = 0; i < 2; i++) await new Promise(requestAnimationFrame);
  });
}

export async function goTo(page, path) {
  await page.evaluate((hash) => { location.hash = `#/${hash}`; scrollTo(0, 0); }, path);
  await settled(page);
}

/** Addresses that the current page links to; numbers become 0, as all cameras have the same pages. */
async function linksOf(page) {
  const links = await page.$$eval('a[href^="#/"]', (all) => all.map((one) => one.getAttribute('href').slice(2)));
  return links.map((link) => link.replace(/\/\d+(?=\/|$)/g, '/0'));
}

/** Clicks a switch that has not been checked yet and returns its name; '' if there is none. */
function pressNext([selector, seen]) {
  const isShown = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
  const all = [...document.querySelectorAll(selector)].filter(isShown);
  // Starts with the last switch, because an earlier switch may have revealed it.
  for (const element of all.reverse()) {
    const group = element.closest('[role="group"][aria-label], section[aria-label], [aria-labelledby], nav[aria-label]');
    const around = group?.getAttribute('aria-label') ?? document.getElementById(group?.getAttribute('aria-labelledby') ?? '')?.textContent ?? '';
    const name = `${around}: ${element.getAttribute('aria-label') ?? element.textContent}`.replace(/\s+/g, ' ').replace(/\d+/g, '0').trim();
    if (seen.includes(name)) continue;
    element.click();
    return name;
  }
  return '';
}

/**
 * Visits one address and everything its switches show. Calls `visit(name)` with the name of the clicked switch, first
 * with ''. Menus and dialogs are closed before the next one. Unless `isDeep`, visits only the address itself.
 */
export async function lookAround(page, path, isDeep, visit) {
  await page.evaluate(() => { location.hash = '#/'; });
  await goTo(page, path);
  await visit('');
  if (!isDeep) return;
  const seen = [];
  for (;;) {
    const name = await page.evaluate(pressNext, [switchesOf(path), seen]);
    if (!name) return;
    seen.push(name);
    await settled(page);
    await visit(name);
    await page.evaluate(() => {
      for (const dialog of document.querySelectorAll('dialog[open]')) dialog.close();
      for (const button of document.querySelectorAll('button[aria-expanded="true"][aria-controls]')) {
        const menu = document.getElementById(button.getAttribute('aria-controls'));
        if (menu && ['absolute', 'fixed'].includes(getComputedStyle(menu).position)) button.click();
      }
    });
  }
}

/** All addresses of the panel, found by following links from every page. */
export async function findPaths(page) {
  const names = pageNames();
  const found = new Set(names);
  for (const path of found) {
    await goTo(page, path);
    for (const link of await linksOf(page)) {
      const [name, ...rest] = link.split('/');
      const path = rest.length ? link : name;
      if (!names.includes(name) || (rest.length && SCROLLED.has(name))) continue;
      // The first camera's page is the same as the address without a number.
      if (/^[a-z]+\/0$/.test(path)) continue;
      found.add(path);
    }
  }
  return [...found];
}

