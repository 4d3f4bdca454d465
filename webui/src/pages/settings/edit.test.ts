// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { SchemaNode } from '../../settings/schema';
import { entryPlace, entryTitle, newEntry, startOf } from './edit';

const schema: SchemaNode = {
  type: 'object',
  properties: {
    ball_models: { type: ['object', 'null'], properties: { acc: { type: 'number', default: -3 } } },
    cameras: {
      type: 'array',
      items: {
        type: 'object',
        properties: { classes: { type: 'array', items: { type: 'object', properties: { label: { type: 'string', default: '' } } } } },
      },
    },
  },
};

describe('edits', () => {
  it('begin with something that works', () => {
    expect(startOf(schema, { ball_models: null }, '/ball_models', null)).toEqual({ acc: -3 });
    expect(newEntry(schema, { cameras: [{ classes: [{ label: 'pink' }] }] }, '/cameras/0/classes')).toEqual({ label: 'pink' });
    expect(newEntry(schema, { cameras: [{ classes: [] }] }, '/cameras/0/classes')).toMatchObject({ label: 'orange' });
  });
  it('find an entry again', () => {
    expect(entryPlace([{ a: 1 }, { a: 2 }, { a: 2 }], 2, { a: 2 })).toBe(2);
    expect(entryPlace([{ a: 2 }, { a: 1 }], 1, { a: 2 })).toBe(0);
    expect(entryPlace([{ a: 1 }], 0, { a: 2 })).toBeNull();
  });
  it('name entries', () => {
    expect(entryTitle({ label: 'blue' }, 0)).toBe('blue');
    expect(entryTitle({ points: [[0, 0], [1, 0], [0, 1]] }, 0)).toBe('Polygon of 3 corners');
    expect(entryTitle({ x: 1 }, 2)).toBe('Entry 3');
  });
});
