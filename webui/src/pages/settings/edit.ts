// SPDX-License-Identifier: Apache-2.0
// Changes of whole parts of the settings: list entries, cameras, optional groups.
import type { Status } from '../../api/types';
import { fieldCurves, fieldLines } from '../../geometry/fieldLines';
import { isEqual, keysOf, pointerOf, valueAt, type Json } from '../../settings/pointer';
import { nodeAt, type SchemaNode } from '../../settings/schema';

const defaultsOf = (node: SchemaNode | undefined): Json => Object.fromEntries(Object.entries(node?.properties ?? {})
  .flatMap(([key, one]) => (one.default === undefined ? [] : [[key, one.default]])));

/** Initial value of an optional part: one that works, or at least shows what to fill in. */
export function startOf(schema: SchemaNode, tree: Json, pointer: string, status: Status | null): Json {
  const key = keysOf(pointer).at(-1);
  if (key === 'field_lines' && status) return fieldLines({ ...status.field, field_lines: null }).map(({ name, p1, p2 }) => ({ name, x1: p1.x, y1: p1.y, x2: p2.x, y2: p2.y, thickness: 0 }));
  if (key === 'field_arcs' && status) return fieldCurves({ ...status.field, field_arcs: null }).map((curve) => ({ ...curve, thickness: 0 }));
  const node = nodeAt(schema, tree, pointer);
  if (node?.items) return [];
  const start = defaultsOf(node) as { [key: string]: Json };
  if (key === 'calibration') {
    const id = valueAt(tree, pointerOf([...keysOf(pointer).slice(0, 2), 'id']));
    const camera = status?.cameras.find((one) => one.id === id);
    const [width, height] = [camera?.width || 780, camera?.height || 580];
    Object.assign(start, { pixel_image_width: width, pixel_image_height: height, principal_point_x: width / 2, principal_point_y: height / 2 });
  }
  return start;
}

/** A new list entry: a copy of the last one, else one that is valid and harmless. */
export function newEntry(schema: SchemaNode, tree: Json, list: string): Json {
  const entries = valueAt(tree, list);
  if (Array.isArray(entries) && entries.length) return entries.at(-1)!;
  const key = keysOf(list).at(-1);
  const start = defaultsOf(nodeAt(schema, tree, list)?.items) as { [key: string]: Json };
  if (key === 'classes') return { ...start, label: 'orange', luma: [60, 255], hue_deg: [108, 147], saturation_pct: [34, 1000] };
  if (key === 'include' || key === 'exclude') return { ...start, points: [[0, 0], [100, 0], [0, 100]] };
  return start;
}

/** A short title for a list entry. */
export function entryTitle(entry: Json, index: number): string {
  for (const key of ['label', 'name']) {
    const text = valueAt(entry, `/${key}`);
    if (typeof text === 'string' && text) return text;
  }
  const points = valueAt(entry, '/points');
  return Array.isArray(points) ? `Polygon of ${points.length} corners` : `Entry ${index + 1}`;
}

/** Current index of the entry that was at `index`; null if it was removed. */
export function entryPlace(list: Json | undefined, index: number, entry: Json): number | null {
  if (!Array.isArray(list)) return null;
  if (isEqual(list[index], entry)) return index;
  const place = list.findIndex((one) => isEqual(one, entry));
  return place < 0 ? null : place;
}
