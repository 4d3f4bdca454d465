// SPDX-License-Identifier: Apache-2.0
// Changes that a profile or a file would make, in selectable sections.
import type { SettingsChange } from '../../api/types';
import { keysOf, pointerOf, type Json, type Operation } from '../../settings/pointer';
import { titleOf } from '../../settings/schema';
import { placeText } from './places';

export interface Section {
  /** The place that contains all its changes. */
  key: string;
  title: string;
  changes: SettingsChange[];
  /** Calibrations depend on where cameras hang, not on preferences. */
  isCalibration: boolean;
}

function sectionKey(path: string): string {
  const keys = keysOf(path);
  return pointerOf(keys[0] === 'cameras' ? keys.slice(0, 3) : keys.slice(0, 1));
}

function sectionTitle(tree: Json, key: string): string {
  const keys = keysOf(key);
  if (keys[0] !== 'cameras' || keys.length === 1) return key === '' ? 'Everything' : titleOf(keys[0]!);
  const camera = placeText(tree, pointerOf(keys.slice(0, 2)));
  const named = camera.charAt(0).toUpperCase() + camera.slice(1);
  return keys.length === 2 ? named : `${named} · ${keys[2] === 'stages' ? 'Stages' : titleOf(keys[2]!)}`;
}

export function sectionsOf(tree: Json, changes: SettingsChange[]): Section[] {
  const sections = new Map<string, Section>();
  for (const change of changes) {
    const key = sectionKey(change.path);
    const section = sections.get(key) ?? { key, title: sectionTitle(tree, key), changes: [], isCalibration: /^\/cameras\/\d+\/calibration$/.test(key) };
    section.changes.push(change);
    sections.set(key, section);
  }
  return [...sections.values()];
}

/** As a patch, in the service's order, because list indices depend on it. */
export const patchOf = (changes: SettingsChange[]): Operation[] => changes.map(({ op, path, after }) =>
  (op === 'remove' ? { op, path } : { op, path, value: after as Json }));

/** Parses the settings in a file's text, or returns the error. */
export function readTree(name: string, text: string): { settings: Json } | { error: string } {
  let parsed: unknown;
  try {
    parsed = JSON.parse(text);
  } catch (error) {
    return { error: `${name} is not valid JSON: ${error instanceof Error ? error.message : String(error)}` };
  }
  if (typeof parsed !== 'object' || parsed === null || Array.isArray(parsed)) return { error: `${name} contains no settings: expected an object { … }` };
  return { settings: parsed as Json };
}
