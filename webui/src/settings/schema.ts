// SPDX-License-Identifier: Apache-2.0
// Looks up the service's JSON Schema for places in the settings tree.
import { keysOf, valueAt, type Json } from './pointer';

/** The part of JSON Schema (2020-12) that daemon/base/params_json.h writes. */
export interface SchemaNode {
  type?: string | string[];
  title?: string;
  description?: string;
  default?: Json;
  minimum?: number;
  maximum?: number;
  'x-unit'?: string;
  enum?: Json[];
  const?: Json;
  properties?: Record<string, SchemaNode>;
  additionalProperties?: boolean;
  items?: SchemaNode;
  minItems?: number;
  maxItems?: number;
  oneOf?: SchemaNode[];
}

/** Of several shapes, the one whose constants ("backend") match the value. */
export function shapeOf(node: SchemaNode, value: Json | undefined): SchemaNode {
  if (!node.oneOf) return node;
  const fits = node.oneOf.find(({ properties }) => Object.entries(properties ?? {})
    .every(([key, one]) => one.const === undefined || valueAt(value, `/${key}`) === one.const));
  return fits ? { ...node, ...fits, oneOf: undefined } : node;
}

/** The node for a pointer; undefined if the schema does not contain it. */
export function nodeAt(schema: SchemaNode, tree: Json, pointer: string): SchemaNode | undefined {
  let node: SchemaNode | undefined = schema;
  let value: Json | undefined = tree;
  for (const key of keysOf(pointer)) {
    if (!node) return undefined;
    const shape: SchemaNode = shapeOf(node, value);
    node = Array.isArray(value) || shape.items ? shape.items : shape.properties?.[key];
    value = valueAt(value, `/${key.replaceAll('~', '~0').replaceAll('/', '~1')}`);
  }
  return node && shapeOf(node, value);
}

export type Kind = 'number' | 'flag' | 'text' | 'choice' | 'numbers' | 'range' | 'points' | 'names' | 'group' | 'list' | 'object';

const types = (node: SchemaNode) => (Array.isArray(node.type) ? node.type : [node.type ?? 'object']);

/** Null is allowed; the help says what it means. */
export const isNullable = (node: SchemaNode) => types(node).includes('null');
export const isWhole = (node: SchemaNode) => types(node).includes('integer');

/** The value, or the default if it is undefined; null is a value. */
export const valueOr = (node: SchemaNode | undefined, value: Json | undefined): Json | undefined => (value === undefined ? node?.default : value);

/** How a value is shown and edited. */
export function kindOf(node: SchemaNode): Kind {
  const type = types(node).find((one) => one !== 'null');
  if (node.enum) return 'choice';
  if (type === 'integer' || type === 'number') return 'number';
  if (type === 'boolean') return 'flag';
  if (type === 'string') return 'text';
  if (type === 'array') {
    const inner = node.items ?? {};
    if (inner.properties || inner.oneOf) return 'list';
    if (types(inner).includes('array')) return 'points';
    if (types(inner).includes('string')) return 'names';
    return node.minItems === 2 && node.maxItems === 2 ? 'range' : 'numbers';
  }
  return node.properties ? 'group' : 'object';
}

/** "robot_distance_mm" as a title: "Robot distance". */
export function titleOf(key: string): string {
  const words = key.replace(/_(mm|ms|us|s|px|hz|deg|pct|m|db|mb)$/, '').split('_').filter(Boolean)
    .map((word) => ({ colors: 'colours', lut: 'LUT', cpu: 'CPU', ttl: 'TTL', rms: 'RMS' })[word] ?? word).join(' ');
  const known: Record<string, string> = { fps: 'Frame rate', tx: 'tx', ty: 'ty', tz: 'tz', 'max dt': 'Longest gap' };
  return known[words] ?? words.charAt(0).toUpperCase() + words.slice(1);
}

/** The allowed range of a number, as a text: "50 to 1400". */
export function rangeText(node: SchemaNode): string {
  const far = (limit: number | undefined) => limit === undefined || Math.abs(limit) >= 1e9;
  const { minimum, maximum } = node;
  if (far(minimum) && far(maximum)) return '';
  if (far(maximum)) return `from ${minimum}`;
  if (far(minimum)) return `up to ${maximum}`;
  return `${minimum} to ${maximum}`;
}
