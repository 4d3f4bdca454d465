// SPDX-License-Identifier: Apache-2.0
// Values of free objects as one types them: JSON where it is JSON, else a text.
import type { Json } from '../../settings/pointer';

export function looseValue(text: string): Json {
  try {
    return JSON.parse(text) as Json;
  } catch {
    return text.trim();
  }
}

/** A text that would be read as something else is shown in its quotes. */
export function looseText(value: Json): string {
  if (typeof value !== 'string') return JSON.stringify(value);
  return looseValue(value) === value ? value : JSON.stringify(value);
}
