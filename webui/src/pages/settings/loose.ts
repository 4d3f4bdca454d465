// SPDX-License-Identifier: Apache-2.0
// Values of free-form objects as typed by the user: JSON if it is valid, else a text.
import type { Json } from '../../settings/pointer';

export function looseValue(text: string): Json {
  try {
    return JSON.parse(text) as Json;
  } catch {
    return text.trim();
  }
}

/** A text that would be parsed as something else is shown in quotes. */
export function looseText(value: Json): string {
  if (typeof value !== 'string') return JSON.stringify(value);
  return looseValue(value) === value ? value : JSON.stringify(value);
}
