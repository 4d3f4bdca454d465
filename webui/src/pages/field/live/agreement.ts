// SPDX-License-Identifier: Apache-2.0
// Distances between cameras' positions, by square of the field.
import type { AgreementTrend, FieldAgreement, FieldDifference } from '../../../api/types';

/** Colours are CSS variables of a scale that is readable with colour blindness. */
export const BANDS = [
  { below_mm: 2, text: 'under 2 mm', colour: '--q2' },
  { below_mm: 5, text: '2 to 5 mm', colour: '--q3' },
  { below_mm: 10, text: '5 to 10 mm', colour: '--q4' },
  { below_mm: Infinity, text: 'over 10 mm', colour: '--q5' },
] as const;

export const bandOf = (mm: number): (typeof BANDS)[number] => BANDS.find(({ below_mm }) => mm < below_mm) ?? BANDS[3];
export const lengthOf = ({ off_x_mm, off_y_mm }: Pick<FieldDifference, 'off_x_mm' | 'off_y_mm'>): number => Math.hypot(off_x_mm, off_y_mm);

/** A square's differences are old after this long without a robot there. */
const OLD_S = 120;

export interface Square {
  x: number;
  y: number;
  /** The worst pair of cameras comes first. */
  pairs: FieldDifference[];
  mm: number;
  isOld: boolean;
}

const worseFirst = (a: FieldDifference, b: FieldDifference) => lengthOf(b) - lengthOf(a);

/** Groups the differences by square, with the distance of its worst pair of cameras. */
export function squaresOf({ differences, time }: FieldAgreement): Square[] {
  const places = new Map<string, FieldDifference[]>();
  for (const one of differences) {
    const key = `${one.x} ${one.y}`;
    places.set(key, [...(places.get(key) ?? []), one]);
  }
  return [...places.values()].map((all) => {
    const pairs = all.sort(worseFirst);
    const [{ x, y }] = pairs as [FieldDifference];
    return { x, y, pairs, mm: lengthOf(pairs[0]!), isOld: time - Math.max(...pairs.map((pair) => pair.time)) > OLD_S };
  });
}

export const worstOf = ({ differences }: FieldAgreement, count: number): FieldDifference[] => [...differences].sort(worseFirst).slice(0, count);

/** A line through the minutes of the last two hours, in a box of 120 x 20; its top is 10 mm. */
export function trendPoints({ minutes, time, off_mm }: Pick<AgreementTrend, 'minutes' | 'time' | 'off_mm'>): string {
  const MOST_MM = 10;
  return [...minutes, { time, off_mm }]
    .map((one) => ({ x: 120 - (time - one.time) / 60, y: 20 - (20 * Math.min(one.off_mm, MOST_MM)) / MOST_MM }))
    .filter(({ x }) => x >= 0)
    .map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`)
    .join(' ');
}

/** Arrows are drawn this many times longer than the difference. */
export const ARROW_TIMES = 40;
/** Longer arrows would hide what is beside them. */
const ARROW_MOST_MM = 800;

/** An arrow on the field, mm. */
export function arrowOf({ off_x_mm, off_y_mm }: Pick<FieldDifference, 'off_x_mm' | 'off_y_mm'>): { dx: number; dy: number } {
  const times = Math.min(ARROW_TIMES, ARROW_MOST_MM / Math.max(1e-9, Math.hypot(off_x_mm, off_y_mm)));
  return { dx: times * off_x_mm, dy: times * off_y_mm };
}
