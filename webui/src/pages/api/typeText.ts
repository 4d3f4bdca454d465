// SPDX-License-Identifier: Apache-2.0
// Short type descriptions of JSON Schemas.

export interface Schema {
  $ref?: string;
  type?: string | string[];
  description?: string;
  enum?: unknown[];
  items?: Schema;
  anyOf?: Schema[];
  properties?: Record<string, Schema>;
  required?: string[];
  minimum?: number;
  maximum?: number;
  default?: unknown;
  format?: string;
}

export interface Piece {
  text: string;
  /** Name of the schema to link to. */
  schema?: string;
}

const nameOf = (reference: string) => reference.slice(reference.lastIndexOf('/') + 1);

/** Returns pieces, so that schema names can be links. */
export function typePieces(schema: Schema): Piece[] {
  if (schema.$ref) return [{ text: nameOf(schema.$ref), schema: nameOf(schema.$ref) }];
  if (schema.anyOf) return schema.anyOf.flatMap((one, i) => [...(i ? [{ text: ' or ' }] : []), ...typePieces(one)]);
  if (schema.enum) return [{ text: schema.enum.map((value) => JSON.stringify(value)).join(' or ') }];
  const types = [schema.type ?? 'any'].flat();
  if (types.join() === 'null') return [{ text: 'null' }];
  const kinds = types.filter((type) => type !== 'null');
  const orNull = types.length > kinds.length ? [{ text: ' or null' }] : [];
  if (kinds[0] === 'array') return [{ text: 'list of ' }, ...typePieces(schema.items ?? {}), ...orNull];
  const bounds = schema.minimum !== undefined || schema.maximum !== undefined
    ? ` ${schema.minimum ?? ''}…${schema.maximum ?? ''}` : '';
  return [{ text: (schema.format ?? kinds.join(' or ')) + bounds }, ...orNull];
}

export interface Member {
  name: string;
  type: Piece[];
  optional: boolean;
  description: string;
  members: Member[];
}

/** The object schema itself, or that of a list's items; undefined if it has no members of its own. */
function objectIn(schema: Schema): Schema | undefined {
  if (schema.$ref) return undefined;
  if (schema.properties) return schema;
  return schema.items && objectIn(schema.items);
}

export function membersOf(schema: Schema): Member[] {
  const object = objectIn(schema);
  return Object.entries(object?.properties ?? {}).map(([name, one]) => ({
    name,
    type: typePieces(one),
    optional: !object?.required?.includes(name),
    description: one.description ?? '',
    members: membersOf(one),
  }));
}
