// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { SchemaNode } from '../../settings/schema';
import { addressOf, byPlace, flat, overview, pageOf, placeText, search } from './places';

const number = (more: Partial<SchemaNode>): SchemaNode => ({ type: 'number', ...more });
const schema: SchemaNode = {
  type: 'object',
  properties: {
    site: { type: 'string', default: 'Field', description: 'name of the field' },
    ball_models: { type: ['object', 'null'], default: { acc: -3 }, properties: { acc: number({ default: -3 }) } },
    network: { type: 'object', properties: { vision: { type: 'object', properties: { port: { type: 'integer', default: 10006, description: 'teams listen here' } } } } },
    cameras: {
      type: 'array',
      default: [],
      items: {
        type: 'object',
        properties: {
          id: { type: 'integer', default: 0 },
          source: {
            type: 'object',
            oneOf: [{ properties: { backend: { const: 'v4l2' }, width: { type: 'integer', default: 0 }, controls: { type: 'object', default: {} } } }],
          },
          calibration: { type: ['object', 'null'], default: null, properties: { focal_length: number({ default: 600 }) } },
          stack: { type: 'array', items: { type: 'string', enum: ['a', 'b'] }, default: ['a', 'b'] },
          stages: { type: 'object', properties: { a: { type: 'object', properties: { x: number({ default: 1 }) } }, b: { type: 'object', properties: { y: number({ default: 1 }) } } } },
        },
      },
    },
  },
};
const tree = {
  site: 'Hall', ball_models: null, network: { vision: { port: 10006 } },
  cameras: [{ id: 3, source: { backend: 'v4l2', width: 640, controls: { gain: 2 } }, calibration: { focal_length: 500 }, stack: ['a'], stages: { a: { x: 2 }, b: { y: 2 } } }],
};

describe('places', () => {
  const { places, settings } = overview(schema, tree);
  const at = (pointer: string) => flat(places).find((place) => place.pointer === pointer)!;
  it('are a tree with what differs counted', () => {
    expect(places.map(({ title }) => title)).toEqual(['General', 'Ball models', 'Network', 'Cameras']);
    expect(at('/cameras/0').children.map(({ title, changed }) => [title, changed]))
      .toEqual([['Source', 1], ['Controls', 1], ['Stack', 2], ['Calibration', 1]]);
    expect(at('/cameras').changed).toBe(6); // those and the id
    expect(at('/network').changed).toBe(0);
    expect(at('').changed).toBe(1);
    expect(at('/ball_models').changed).toBe(1);
  });
  it('leave out what is not in use', () => {
    expect(settings.some(({ pointer }) => pointer.includes('/stages/b'))).toBe(false);
  });
  it('count a calibration once and show its numbers plain', () => {
    expect(settings.find(({ pointer }) => pointer.endsWith('/focal_length'))).toMatchObject({ isChanged: false, plain: true, isRow: true });
  });
  it('are searched by key, help and place', () => {
    expect(search(settings, 'teams LISTEN').map(({ pointer }) => pointer)).toEqual(['/network/vision/port']);
    expect(search(settings, 'camera 3 width').map(({ key }) => key)).toEqual(['width']);
    expect(byPlace(search(settings, 'width'))[0]!.path).toEqual(['Cameras', 'Camera 3', 'Source']);
    expect(byPlace(search(settings, 'port'))[0]!.path).toEqual(['Network', 'Vision']);
    expect(search(settings, 'nothing like it')).toEqual([]);
  });
  it('have pages and names', () => {
    expect(pageOf(schema, tree, '/network/vision/port')).toBe('/network/vision');
    expect(pageOf(schema, tree, '/cameras/0/stack')).toBe('/cameras/0/stack');
    expect(pageOf(schema, tree, '/site')).toBe('');
    expect(placeText(tree, '/cameras/0/stages/a/x')).toBe('camera 3 / a / x');
    expect(placeText(tree, '')).toBe('everything');
    expect(addressOf('/network')).toBe('network');
    expect(addressOf('')).toBe('~general');
  });
});
