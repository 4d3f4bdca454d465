// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { kindOf, nodeAt, rangeText, shapeOf, titleOf, type SchemaNode } from './schema';

const schema: SchemaNode = {
  type: 'object',
  properties: {
    cameras: {
      type: 'array',
      items: {
        type: 'object',
        properties: {
          id: { type: 'integer', minimum: 0, maximum: 255 },
          source: {
            type: 'object',
            oneOf: [
              { properties: { backend: { const: 'files' }, path: { type: 'string' } } },
              { properties: { backend: { const: 'simulator' }, frame_rate_hz: { type: 'number' } } },
            ],
          },
        },
      },
    },
  },
};
const tree = { cameras: [{ id: 0, source: { backend: 'simulator', frame_rate_hz: 60 } }] };

describe('schema', () => {
  it('finds the node of a place, through lists and shapes', () => {
    expect(nodeAt(schema, tree, '/cameras/0/id')?.maximum).toBe(255);
    expect(nodeAt(schema, tree, '/cameras/0/source/frame_rate_hz')?.type).toBe('number');
    expect(nodeAt(schema, tree, '/cameras/0/source/path')).toBeUndefined();
    expect(nodeAt(schema, tree, '/nothing/here')).toBeUndefined();
    expect(shapeOf(schema.properties!.cameras!.items!.properties!.source!, { backend: 'files' }).properties).toHaveProperty('path');
  });
  it('knows how values are edited', () => {
    expect(kindOf({ type: ['integer', 'null'] })).toBe('number');
    expect(kindOf({ type: 'string', enum: ['a'] })).toBe('choice');
    expect(kindOf({ type: 'array', minItems: 2, maxItems: 2, items: { type: 'integer' } })).toBe('range');
    expect(kindOf({ type: 'array', items: { type: 'string' } })).toBe('names');
    expect(kindOf({ type: 'array', items: { type: 'array' } })).toBe('points');
    expect(kindOf(schema.properties!.cameras!)).toBe('list');
  });
  it('reads well', () => {
    expect(titleOf('robot_distance_mm')).toBe('Robot distance');
    expect(titleOf('quota_mb')).toBe('Quota');
    expect(rangeText({ minimum: 0, maximum: 255 })).toBe('0 to 255');
    expect(rangeText({ minimum: 0, maximum: 1e12 })).toBe('from 0');
  });
});
