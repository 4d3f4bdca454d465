// SPDX-License-Identifier: Apache-2.0
import type { SettingsChange, SettingsStep } from '../../api/types';
import { keysOf, valueAt, type Json } from '../../settings/pointer';

const idOf = (camera: unknown) => valueAt(camera as Json, '/id') ?? null;
const idsOf = (cameras: unknown) => (Array.isArray(cameras) ? cameras.map(idOf) : []);

/** The camera ids before a change, derived from those after it. */
function takenBack(change: SettingsChange, ids: (Json | null)[]): (Json | null)[] {
  const [list, index, key, ...rest] = keysOf(change.path);
  if (list === undefined) return idsOf(valueAt(change.before as Json, '/cameras'));
  if (list !== 'cameras') return ids;
  if (index === undefined) return idsOf(change.before);
  const i = Number(index);
  if (key === undefined && change.op === 'add') return [...ids.slice(0, i), ...ids.slice(i + 1)];
  if (key === undefined && change.op === 'remove') return [...ids.slice(0, i), idOf(change.before), ...ids.slice(i)];
  const was = key === undefined ? idOf(change.before) : key === 'id' && !rest.length ? change.before as Json : ids[i];
  return ids.map((id, at) => (at === i ? was ?? null : id));
}

/**
 * The id of the camera that each change affected, derived from the steps (newest first) and the current settings: a
 * path only contains the index in the list at that time. Null: no camera.
 */
export function camerasOfSteps(settings: Json | null, steps: SettingsStep[]): Map<SettingsChange, Json | null> {
  const out = new Map<SettingsChange, Json | null>();
  let ids = idsOf(valueAt(settings ?? undefined, '/cameras'));
  for (const step of steps) {
    for (const change of [...step.changes].reverse()) {
      const before = takenBack(change, ids);
      const [list, index] = keysOf(change.path);
      // A removed camera is found in the list before the change.
      out.set(change, list === 'cameras' && index !== undefined ? (change.op === 'remove' ? before : ids)[Number(index)] ?? null : null);
      ids = before;
    }
  }
  return out;
}
