// SPDX-License-Identifier: Apache-2.0
// Labels as the user selects them: order, names and keys.
import type { ColorLabel } from '../../api/types';
import type { Rgb } from '../../picture/exposure';
import { CLEAR } from './table';

/** The most used labels first; the admin's own labels follow. */
const ORDER = ['orange', 'yellow', 'blue', 'pink', 'green', 'cyan', 'field', 'white', 'black'];
const WHAT: Readonly<Record<string, string>> = {
  orange: 'ball', yellow: 'team', blue: 'team', pink: 'dots', green: 'dots', cyan: 'dots', field: 'carpet', white: 'lines', black: 'robot tops',
};

/** Labels that can be selected; clear means that a cell has no label. */
export function choosable(labels: readonly ColorLabel[]): ColorLabel[] {
  const place = ({ name, value }: ColorLabel) => (ORDER.includes(name) ? ORDER.indexOf(name) : ORDER.length + value);
  return labels.filter(({ value }) => value !== CLEAR).sort((a, b) => place(a) - place(b));
}

export const titleOfLabel = (name: string) => name.charAt(0).toUpperCase() + name.slice(1);
/** What has that colour on a field; empty for an own label. */
export const useOfLabel = ({ name, built_in }: ColorLabel) => (built_in ? WHAT[name] ?? '' : '');
/** The key of a label: 1 to 9, then 0; further labels have none. */
export const keyOf = (index: number) => (index < 9 ? String(index + 1) : index === 9 ? '0' : '');

export function rgbOf(color: string): Rgb {
  const value = Number.parseInt(color.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

/** Pixel values (32-bit view of ImageData) by label; hidden labels look clear. */
export function palette(labels: readonly ColorLabel[], hidden: ReadonlySet<number>): Uint32Array {
  const clear = labels.find(({ value }) => value === CLEAR)?.color ?? '#34363a';
  const pixel = (color: string) => {
    const [r, g, b] = rgbOf(color);
    return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
  };
  const table = new Uint32Array(256).fill(pixel(clear));
  for (const { value, color } of labels) if (!hidden.has(value)) table[value] = pixel(color);
  return table;
}

/** The first unused value for an own label; null if all are used. */
export function freeValue(labels: readonly ColorLabel[]): number | null {
  for (let value = 10; value < 32; value++) if (!labels.some((one) => one.value === value)) return value;
  return null;
}

/** "adds 27 cells to Pink, 3 of them now Orange; 12 cells stay carpet" */
export function trialText(edited: { cells: number; from: readonly { label: string; cells: number }[]; left_to_carpet: number }, label: string, takesAway: boolean): string {
  const name = titleOfLabel(label);
  const left = edited.left_to_carpet ? `; ${edited.left_to_carpet} ${edited.left_to_carpet === 1 ? 'cell stays' : 'cells stay'} carpet` : '';
  if (edited.cells === 0) return takesAway ? `removes nothing from ${name}` : `is already ${name}${left}`;
  const cells = `${edited.cells} ${edited.cells === 1 ? 'cell' : 'cells'}`;
  if (takesAway) return `removes ${cells} from ${name}`;
  const others = edited.from.filter((one) => one.label !== 'clear' && one.label !== label);
  const now = others.map((one) => `${one.cells} of them now ${titleOfLabel(one.label)}`);
  return [`adds ${cells} to ${name}`, ...now].join(', ') + left;
}
