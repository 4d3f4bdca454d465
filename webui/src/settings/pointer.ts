// SPDX-License-Identifier: Apache-2.0
// JSON Pointers (RFC 6901) into the settings tree.

/** String comes before boolean: otherwise Vue would turn a component's property '' into true. */
export type Json = null | string | boolean | number | Json[] | { [key: string]: Json };

export const escapeKey = (key: string | number) => String(key).replaceAll('~', '~0').replaceAll('/', '~1');
const unescapeKey = (key: string) => key.replaceAll('~1', '/').replaceAll('~0', '~');

export const keysOf = (pointer: string): string[] => (pointer === '' ? [] : pointer.slice(1).split('/').map(unescapeKey));
export const pointerOf = (keys: (string | number)[]): string => keys.map((key) => `/${escapeKey(key)}`).join('');

/** The value at a pointer; undefined if there is none. */
export function valueAt(tree: Json | undefined, pointer: string): Json | undefined {
  let value = tree;
  for (const key of keysOf(pointer)) {
    if (typeof value !== 'object' || value === null) return undefined;
    value = Array.isArray(value) ? value[Number(key)] : Object.hasOwn(value, key) ? value[key] : undefined;
  }
  return value;
}

/** Whether they are equal, or one contains the other. */
export const overlap = (a: string, b: string): boolean => a === b || a.startsWith(`${b}/`) || b.startsWith(`${a}/`);

export const isEqual = (a: Json | undefined, b: Json | undefined): boolean => {
  if (a === b) return true;
  if (typeof a !== 'object' || typeof b !== 'object' || a === null || b === null) return false;
  if (Array.isArray(a) !== Array.isArray(b)) return false;
  const [keysA, keysB] = [Object.keys(a), Object.keys(b)];
  return keysA.length === keysB.length
    && keysA.every((key) => Object.hasOwn(b, key) && isEqual((a as Record<string, Json>)[key], (b as Record<string, Json>)[key]));
};

export interface Operation {
  /** `test` refuses the whole patch unless the value at the path is equal. */
  op: 'add' | 'remove' | 'replace' | 'test';
  path: string;
  value?: Json;
}

/** A patch that sets a value and creates missing objects on its path. */
export function setOperations(tree: Json, pointer: string, value: Json): Operation[] {
  const keys = keysOf(pointer);
  for (let depth = 1; depth < keys.length; depth++) {
    if (valueAt(tree, pointerOf(keys.slice(0, depth))) !== undefined) continue;
    // One operation adds the whole missing branch.
    const branch = keys.slice(depth).reduceRight<Json>((inner, key) => ({ [key]: inner }), value);
    return [{ op: 'add', path: pointerOf(keys.slice(0, depth)), value: branch }];
  }
  return [{ op: valueAt(tree, pointer) === undefined ? 'add' : 'replace', path: pointer, value }];
}
