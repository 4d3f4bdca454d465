// SPDX-License-Identifier: Apache-2.0
// Adds a camera to the settings.
import { valueAt, type Json } from '../settings/pointer';
import { save, type Outcome } from '../state/settings';

export const idsOf = (tree: Json) => {
  const cameras = valueAt(tree, '/cameras');
  return (Array.isArray(cameras) ? cameras : []).map((camera) => valueAt(camera, '/id'));
};

/** The lowest unused camera id. */
export function freeId(tree: Json): number {
  const taken = idsOf(tree);
  let id = 0;
  while (taken.includes(id)) id++;
  return id;
}

export interface Added { outcome: Outcome; id: number }

/** Saves one more camera. `settings`: its settings except the id. */
export async function addCamera(settings: (tree: Json) => Json): Promise<Added> {
  let id = 0;
  const outcome = await save((tree) => {
    id = freeId(tree);
    return [{ op: 'add', path: '/cameras/-', value: { ...(settings(tree) as object), id } }];
  });
  return { outcome, id };
}

/** Only names of JPEG and PNG files may be uploaded. */
export const isImageName = (name: string) => /\.(jpe?g|png)$/i.test(name);

/** Name of a folder for images uploaded now, such as "images 2026-11-25 14.03.07". */
export function folderName(now: Date): string {
  const two = (value: number) => String(value).padStart(2, '0');
  return `images ${now.getFullYear()}-${two(now.getMonth() + 1)}-${two(now.getDate())} ${two(now.getHours())}.${two(now.getMinutes())}.${two(now.getSeconds())}`;
}

/** Whether a text is an IPv4 address. */
export const isAddress = (text: string) => /^(\d{1,3}\.){3}\d{1,3}$/.test(text) && text.split('.').every((part) => Number(part) <= 255);
