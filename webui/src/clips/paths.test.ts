// SPDX-License-Identifier: Apache-2.0
import { expect, it, vi } from 'vitest';

// The router reads the browser's address.
vi.stubGlobal('location', { hash: '' });
vi.stubGlobal('addEventListener', () => {});
vi.mock('../router', () => ({ link: (name: string, argument?: string) => (argument === undefined ? `#/${name}` : `#/${name}/${argument}`) }));
const { clipLink, clipPath, logLink, playerAddress } = await import('./paths');

it('makes addresses that it understands again', () => {
  const name = '2026-11-26_22-40_a b.clip';
  expect(clipPath(name)).toBe('recordings/clips/2026-11-26_22-40_a%20b.clip');
  expect(playerAddress(clipLink(name).slice('#/recordings/'.length))).toEqual({ kind: 'clips', name, camera: null, compare: null });
  expect(playerAddress(clipLink(name, 3, 'learnt_colors').slice('#/recordings/'.length))).toEqual({ kind: 'clips', name, camera: 3, compare: 'learnt_colors' });
  expect(playerAddress(logLink('a.log.gz').slice('#/recordings/'.length))).toMatchObject({ kind: 'logs', name: 'a.log.gz' });
});

it('leaves what is no player to the page', () => {
  expect(playerAddress('')).toBeNull();
  expect(playerAddress('2026-07-03_14-05_a.log.gz')).toBeNull();
  expect(playerAddress('clips/')).toBeNull();
  expect(playerAddress('clips/a.clip/x/everything')).toEqual({ kind: 'clips', name: 'a.clip', camera: null, compare: null });
  expect(playerAddress('clips/%')).toMatchObject({ name: '%' });
});
