// SPDX-License-Identifier: Apache-2.0
// The settings as a tree of places, grouped for an admin, with the differences from the defaults.
import { isEqual, keysOf, pointerOf, valueAt, type Json } from '../../settings/pointer';
import { isNullable, kindOf, nodeAt, shapeOf, titleOf, valueOr, type SchemaNode } from '../../settings/schema';

export interface Setting {
  pointer: string;
  title: string;
  key: string;
  help: string;
  place: Place;
  /** Titles of its place, and of the groups there that contain it. */
  path: string[];
  /** Differs from its default. */
  isChanged: boolean;
  /** Has a control of its own; the others have a page. */
  isRow: boolean;
  /** Its default is meaningless; see SettingRow. */
  plain: boolean;
}

export interface Place {
  pointer: string;
  title: string;
  /** A short summary of its contents. */
  fact: string;
  /** Titles from the root to this place. */
  path: string[];
  children: Place[];
  /** Number of settings here and below that differ from their defaults. */
  changed: number;
}

/** Pages outside the tree. A bare "~" is invalid in a JSON Pointer, so no key can have these names. */
export const GENERAL = '~general';
export const PROFILES = '~profiles';
export const HISTORY = '~history';

const CAMERA_PARTS = ['source', 'controls', 'stack', 'colors', 'mask', 'calibration', 'thread'];

export const cameraOf = (pointer: string): number | null => {
  const [list, index] = keysOf(pointer);
  return list === 'cameras' && index !== undefined && /^\d+$/.test(index) ? Number(index) : null;
};

/** The stage whose parameters are at a pointer. */
export const stageOf = (pointer: string): string | null => {
  const [list, , stages, stage] = keysOf(pointer);
  return list === 'cameras' && stages === 'stages' ? stage ?? null : null;
};

const count = (value: Json | undefined, one: string, many = `${one}s`) => {
  const n = Array.isArray(value) ? value.length : 0;
  return n ? `${n} ${n === 1 ? one : many}` : '';
};

function factOf(part: string, value: Json | undefined): string {
  if (part === 'source') return String(valueAt(value, '/backend') ?? '');
  if (part === 'stack') return count(value, 'stage');
  if (part === 'colors') return String(valueAt(value, '/lut_file') || count(valueAt(value, '/classes'), 'class', 'classes'));
  if (part === 'mask') return [count(valueAt(value, '/include'), 'inside'), count(valueAt(value, '/exclude'), 'outside')].filter(Boolean).map((text) => text.replace(/s$/, '')).join(', ');
  return value === null ? 'none' : '';
}

export interface Overview {
  places: Place[];
  settings: Setting[];
}

/** All settings in use, without the parameters of stages that are not in a stack. */
export function overview(schema: SchemaNode, tree: Json): Overview {
  const settings: Setting[] = [];
  const newPlace = (pointer: string, title: string, fact: string, parent?: Place): Place => {
    const place: Place = { pointer, title, fact, path: [...(parent?.path ?? []), title], children: [], changed: 0 };
    parent?.children.push(place);
    return place;
  };
  const add = (place: Place, pointer: string, node: SchemaNode, isChanged: boolean, isRow: boolean, plain = false, path = place.path) => {
    const key = keysOf(pointer).at(-1) ?? '';
    settings.push({ pointer, key, title: titleOf(key), help: node.description ?? '', place, path, isChanged, isRow, plain });
  };

  function walk(place: Place, pointer: string, node: SchemaNode, plain = false, without: string[] = [], path = place.path): void {
    for (const [key, raw] of Object.entries(node.properties ?? {})) {
      if (without.includes(key)) continue;
      const here = pointer + pointerOf([key]);
      const value = valueOr(raw, valueAt(tree, here));
      const child = shapeOf(raw, value);
      const differs = raw.default !== undefined && !isEqual(value, raw.default);
      const kind = kindOf(child);
      if (kind === 'group') whole(place, here, child, value, differs, plain, [...path, titleOf(key)]);
      else add(place, here, child, differs && !plain, !['list', 'object'].includes(kind), plain, path);
    }
  }

  /** A group that is absent by default counts as one setting: its numbers have no defaults. */
  function whole(place: Place, pointer: string, node: SchemaNode, value: Json | undefined, differs: boolean, plain: boolean, path = place.path): void {
    const isAbsent = isNullable(node) && value === null;
    const startsAbsent = isNullable(node) && node.default === null;
    if (isNullable(node) && (isAbsent || startsAbsent)) add(place, pointer, node, differs, false, false, path);
    if (!isAbsent) walk(place, pointer, node, plain || startsAbsent, [], path);
  }

  function cameraParts(camera: Place, node: SchemaNode): void {
    const value = valueAt(tree, camera.pointer);
    walk(camera, camera.pointer, node, false, [...CAMERA_PARTS, 'stages', ...Object.keys(node.properties ?? {}).filter((key) => kindOf(node.properties![key]!) === 'group')]);
    const parts = Object.keys(node.properties ?? {}).filter((key) => !['id', 'name', 'stages'].includes(key));
    const order = (key: string) => (CAMERA_PARTS.includes(key) ? CAMERA_PARTS.indexOf(key) : CAMERA_PARTS.length);
    for (const part of [...parts].sort((a, b) => order(a) - order(b))) {
      const pointer = `${camera.pointer}/${part}`;
      const raw = node.properties![part]!;
      const here = valueOr(raw, valueAt(value, `/${part}`));
      const shape = shapeOf(raw, here);
      const kind = kindOf(shape);
      if (kind !== 'group' && part !== 'stack') continue;
      const place = newPlace(pointer, titleOf(part), factOf(part, here), camera);
      if (part === 'source') {
        walk(place, pointer, shape, false, ['controls']);
        const controls = shape.properties?.controls;
        if (controls) {
          const set = valueAt(here, '/controls') ?? {};
          const sets = Object.keys(set as object).length;
          add(newPlace(`${pointer}/controls`, 'Controls', sets ? `${sets} set` : '', camera), `${pointer}/controls`, controls, sets > 0, false);
        }
      } else if (part === 'stack') {
        add(place, pointer, shape, !isEqual(here, raw.default), false);
        for (const stage of new Set(Array.isArray(here) ? here.map(String) : [])) {
          const stageNode = node.properties?.stages?.properties?.[stage];
          if (stageNode) walk(newPlace(`${camera.pointer}/stages/${stage}`, stage, '', place), `${camera.pointer}/stages/${stage}`, stageNode);
        }
      } else {
        whole(place, pointer, shape, here, !isEqual(here, raw.default), false);
      }
    }
  }

  const general = newPlace('', 'General', '');
  const places = [general];
  for (const [key, raw] of Object.entries(schema.properties ?? {})) {
    const pointer = pointerOf([key]);
    const value = valueOr(raw, valueAt(tree, pointer));
    const kind = kindOf(raw);
    if (key === 'cameras' && raw.items) {
      const cameras = newPlace(pointer, 'Cameras', '');
      places.push(cameras);
      (Array.isArray(value) ? value : []).forEach((camera, index) => {
        const place = newPlace(`${pointer}/${index}`, `Camera ${valueAt(camera, '/id') ?? index}`, String(valueAt(camera, '/name') ?? ''), cameras);
        cameraParts(place, raw.items!);
      });
    } else if (kind === 'group') {
      const place = newPlace(pointer, titleOf(key), value === null ? 'none' : '');
      places.push(place);
      whole(place, pointer, raw, value, raw.default !== undefined && !isEqual(value, raw.default), false);
    } else {
      add(general, pointer, raw, raw.default !== undefined && !isEqual(value, raw.default), kind !== 'list' && kind !== 'object');
    }
  }

  for (const { place, isChanged } of settings) if (isChanged) place.changed++;
  const sum = (place: Place): number => (place.changed += place.children.reduce((total, child) => total + sum(child), 0));
  for (const place of places) sum(place);
  return { places, settings };
}

/** All places, parents before their children. */
export const flat = (places: Place[]): Place[] => places.flatMap((place) => [place, ...flat(place.children)]);

/** The settings whose title, key, help or place contains all words. */
export function search(settings: Setting[], query: string): Setting[] {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  return settings.filter(({ title, key, help, path, pointer }) => {
    const text = `${title} ${key} ${help} ${path.join(' ')} ${pointer}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

export interface PlaceGroup {
  place: Place;
  path: string[];
  settings: Setting[];
}

/** Groups settings by place. */
export function byPlace(settings: Setting[]): PlaceGroup[] {
  const groups = new Map<string, PlaceGroup>();
  for (const setting of settings) {
    const { place, path } = setting;
    const key = `${place.pointer}\n${path.join('\n')}`;
    const group = groups.get(key) ?? { place, path, settings: [] };
    group.settings.push(setting);
    groups.set(key, group);
  }
  return [...groups.values()];
}

/** The page for a pointer: the place itself if it is a group or a list, else the one that contains it. */
export function pageOf(schema: SchemaNode, tree: Json, pointer: string): string {
  const node = nodeAt(schema, tree, pointer);
  if (pointer === '' || !node) return pointer;
  const isPage = ['group', 'list', 'object'].includes(kindOf(node)) || (node.type === 'array' && /^\/cameras\/\d+\/stack$/.test(pointer));
  return isPage ? pointer : pageOf(schema, tree, pointerOf(keysOf(pointer).slice(0, -1)));
}

/**
 * "Camera 0 / detect_balls / min_area_ratio": a place of the settings in one line. `camera`: the id of the camera, if
 * it is not the one at that index in the tree.
 */
export function placeText(tree: Json | null, pointer: string, camera?: Json): string {
  const keys = keysOf(pointer);
  if (keys[0] === 'cameras' && keys.length > 1) {
    const id = camera ?? valueAt(tree ?? undefined, pointerOf([...keys.slice(0, 2), 'id']));
    keys.splice(0, 2, `camera ${id ?? `no. ${keys[1]}`}`);
    if (keys[1] === 'stages') keys.splice(1, 1);
  }
  return keys.length ? keys.join(' / ') : 'everything';
}

/** The places of a step in one line; only the first one of many. */
export function placesText(tree: Json | null, paths: string[]): string {
  const texts = [...new Set(paths.map((path) => placeText(tree, path)))];
  return texts.length > 2 ? `${texts[0]} and ${texts.length - 1} more` : texts.join(' and ');
}

/** The address of a place. */
export const addressOf = (pointer: string) => (pointer === '' ? GENERAL : pointer.startsWith('/') ? pointer.slice(1) : pointer);
