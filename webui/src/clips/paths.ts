// SPDX-License-Identifier: Apache-2.0
// Addresses of clips in the API and in the panel.
import type { CompareWith } from '../api/types';
import { link } from '../router';

export const clipPath = (name: string): string => `recordings/clips/${encodeURIComponent(name)}`;

/** Link to the player; with `compare`, the player starts that comparison. */
export function clipLink(name: string, camera?: number, compare?: CompareWith): string {
  const more = [...(camera === undefined ? [] : [camera]), ...(camera === undefined || !compare ? [] : [compare])];
  return link('recordings', ['clips', encodeURIComponent(name), ...more].join('/'));
}
export const logLink = (name: string): string => link('recordings', `logs/${encodeURIComponent(name)}`);

export interface PlayerAddress {
  kind: 'clips' | 'logs';
  name: string;
  camera: number | null;
  compare: CompareWith | null;
}

/** What an address after "recordings/" plays; null: nothing. */
export function playerAddress(path: string): PlayerAddress | null {
  const [kind, name, camera = '', compare = ''] = path.split('/');
  if ((kind !== 'clips' && kind !== 'logs') || !name) return null;
  let plain = name;
  try {
    plain = decodeURIComponent(name);
  } catch {
    // Malformed: the service will not know the name.
  }
  return {
    kind, name: plain, camera: /^\d+$/.test(camera) ? Number(camera) : null,
    compare: compare === 'recorded_settings' || compare === 'settings_now' || compare === 'learnt_colors' ? compare : null,
  };
}
