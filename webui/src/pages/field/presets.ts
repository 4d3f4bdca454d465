// SPDX-License-Identifier: Apache-2.0
import type { FieldPreset } from '../../api/types';
import { isEqual, pointerOf, setOperations, type Json, type Operation } from '../../settings/pointer';

export interface Difference {
  key: string;
  before: Json;
  after: Json;
}

/** What a preset would change in the field. */
export function differences(field: Json | undefined, preset: FieldPreset): Difference[] {
  const now = (field ?? {}) as Record<string, Json>;
  return Object.entries(preset.field as Record<string, Json>)
    .map(([key, after]) => ({ key, before: now[key] ?? null, after }))
    .filter(({ before, after }) => !isEqual(before, after));
}

/** One patch for all changes. */
export const presetOperations = (tree: Json, changes: Difference[]): Operation[] =>
  changes.flatMap(({ key, after }) => setOperations(tree, pointerOf(['field', key]), after));

/** "Division A, 2026" without the year, for a button. */
export const shortName = ({ description, name }: FieldPreset): string => description.split(',')[0] || name;
