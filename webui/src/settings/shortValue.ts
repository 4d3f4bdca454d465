// SPDX-License-Identifier: Apache-2.0
import type { Json } from './pointer';

const MOST = 48;

/** Text after a refused value: the value that remains in use. */
export const stillUsed = (text: string) => (['empty', 'none', 'nothing'].includes(text) ? 'The setting is still empty.' : `The service still uses ${text}.`);

/** A setting's value in a few words, with its unit. */
export function shortValue(value: unknown, unit = ''): string {
  if (value === undefined) return 'nothing';
  if (value === null) return 'none';
  if (typeof value === 'boolean') return value ? 'on' : 'off';
  if (typeof value === 'number') return `${Number(value.toPrecision(9))}${unit && ` ${unit}`}`;
  if (typeof value === 'string') return value === '' ? 'empty' : value.length > MOST ? `${value.slice(0, MOST)}…` : value;
  if (Array.isArray(value)) {
    const text = value.every((one) => typeof one !== 'object') ? value.join(', ') : `${value.length} entries`;
    return text === '' ? 'none' : text.length > MOST ? `${value.length} entries` : text;
  }
  const keys = Object.keys(value as Record<string, Json>);
  return keys.length ? `${keys.length} values` : 'nothing';
}
