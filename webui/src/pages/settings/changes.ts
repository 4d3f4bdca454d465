// SPDX-License-Identifier: Apache-2.0
// Changes that a profile or a file would make, in the parts that one ticks.
import type { SettingsChange } from '../../api/types';
import { keysOf, pointerOf, type Json, type Operation } from '../../settings/pointer';
import { titleOf } from '../../settings/schema';
import { placeText } from './places';

export interface Section {
  /** The place that all of it lies at. */
  key: string;
  title: string;
  changes: SettingsChange[];
  /** Calibrations belong to where cameras hang, not to how one wants to play. */
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

/** As a patch, in the order in which the service made them: places in lists count on it. */
export const patchOf = (changes: SettingsChange[]): Operation[] => changes.map(({ op, path, after }) =>
  (op === 'remove' ? { op, path } : { op, path, value: after as Json }));

/** The settings in a file's text, or what is wrong with it. */
export function readTree(name: string, text: string): { settings: Json } | { error: string } {
  let parsed: unknown;
  try {
    parsed = JSON.parse(text);
  } catch (error) {
    return { error: `${name} is not valid JSON: ${error instanceof Error ? error.message : String(error)}` };
  }
  if (typeof parsed !== 'object' || parsed === null || Array.isArray(parsed)) return { error: `${name} holds no settings: expected an object { … }` };
  return { settings: parsed as Json };
}
