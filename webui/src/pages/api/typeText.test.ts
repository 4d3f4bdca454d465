// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { membersOf, typePieces, type Schema } from './typeText';

const text = (schema: Schema) => typePieces(schema).map((piece) => piece.text).join('');

describe('types in words', () => {
  it('names what is allowed', () => {
    expect(text({ type: 'integer', minimum: 1, maximum: 100 })).toBe('integer 1…100');
    expect(text({ type: ['number', 'null'] })).toBe('number or null');
    expect(text({ type: ['boolean', 'number', 'string', 'null'] })).toBe('boolean or number or string or null');
    expect(text({ enum: ['bad', null] })).toBe('"bad" or null');
    expect(text({ anyOf: [{ $ref: '#/components/schemas/Robot' }, { type: 'null' }] })).toBe('Robot or null');
    expect(text({ type: ['array', 'null'], items: { type: 'string' } })).toBe('list of string or null');
    expect(text({})).toBe('any');
  });

  it('links to schemas', () => {
    expect(typePieces({ type: 'array', items: { $ref: '#/components/schemas/Ball' } })[1]).toEqual({ text: 'Ball', schema: 'Ball' });
  });

  it('lists members, and those of members', () => {
    const point: Schema = { type: 'object', properties: { x: { type: 'number', description: 'px' } }, required: ['x'] };
    const [force, points] = membersOf({ type: 'object', properties: { force: { type: 'boolean' }, points: { type: 'array', items: point } }, required: ['points'] });
    expect(force).toMatchObject({ name: 'force', optional: true, members: [] });
    expect(points).toMatchObject({ optional: false, members: [{ name: 'x', description: 'px', optional: false }] });
    expect(membersOf({ $ref: '#/components/schemas/Ball' })).toEqual([]);
  });
});
