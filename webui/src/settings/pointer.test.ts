// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { isEqual, keysOf, overlap, pointerOf, setOperations, valueAt } from './pointer';

describe('pointers', () => {
  const tree = { cameras: [{ id: 0, stages: { segment: { threads: 2 } } }], 'a/b': 1 };
  it('finds values', () => {
    expect(valueAt(tree, '')).toBe(tree);
    expect(valueAt(tree, '/cameras/0/stages/segment/threads')).toBe(2);
    expect(valueAt(tree, '/a~1b')).toBe(1);
    expect(valueAt(tree, '/cameras/1/id')).toBeUndefined();
    expect(valueAt(tree, '/cameras/0/constructor')).toBeUndefined();
    expect(pointerOf(keysOf('/a~1b/~0'))).toBe('/a~1b/~0');
  });
  it('knows what lies in what', () => {
    expect(overlap('/a', '/a/b')).toBe(true);
    expect(overlap('/a/b', '/a')).toBe(true);
    expect(overlap('/a', '/ab')).toBe(false);
  });
  it('compares values', () => {
    expect(isEqual([1, { a: null }], [1, { a: null }])).toBe(true);
    expect(isEqual({ a: 1 }, { a: 1, b: 2 })).toBe(false);
    expect(isEqual([], {})).toBe(false);
  });
  it('sets what is there and what is not', () => {
    expect(setOperations(tree, '/cameras/0/id', 3)).toEqual([{ op: 'replace', path: '/cameras/0/id', value: 3 }]);
    expect(setOperations(tree, '/cameras/0/stages/publish/on', true)).toEqual([{ op: 'add', path: '/cameras/0/stages/publish', value: { on: true } }]);
    expect(setOperations(tree, '/cameras/0/stages/segment/x', 1)).toEqual([{ op: 'add', path: '/cameras/0/stages/segment/x', value: 1 }]);
  });
});
