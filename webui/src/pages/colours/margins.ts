// SPDX-License-Identifier: Apache-2.0
// The margins of a table's labels to carpet and floor, as texts.
import type { ColorMargin, ColorState } from '../../api/types';
import { decimal } from '../../format';

export type MarginKind = 'ok' | 'warn' | 'bad';

/** A label's smallest margin to the carpet. */
export interface MarginRow {
  label: string;
  /** Relative change of the light: 0.09 is brighter, -0.09 darker; null: the label is never reached. */
  change: number | null;
  kind: MarginKind;
  text: string;
}

/** "carpet becomes green at +9 %" */
export function marginText(surface: string, label: string, change: number | null): string {
  if (change === null) return `${surface} never becomes ${label}`;
  const percent = Math.round(100 * Math.abs(change));
  if (percent === 0) return `${surface} is ${label} now`;
  return `${surface} becomes ${label} at ${change < 0 ? decimal(-percent, 0) : `+${percent}`} %`;
}

type Judged = Pick<ColorState, 'wanted_margin' | 'least_margin'>;
export function kindOf(change: number | null, { wanted_margin, least_margin }: Judged): MarginKind {
  const margin = change === null ? Infinity : Math.abs(change);
  return margin < least_margin ? 'bad' : margin < wanted_margin ? 'warn' : 'ok';
}

const distance = (change: number | null) => Math.abs(change ?? Infinity);
/** A label's smallest margin to its surface, signed; null: none. */
const nearest = ({ brighter, darker }: ColorMargin) => (distance(darker) < distance(brighter) ? -darker! : brighter);
const ofSurface = (margins: readonly ColorMargin[], surface: ColorMargin['surface']) =>
  margins.filter((one) => one.surface === surface).map((one) => ({ label: one.label, change: nearest(one) })).sort((a, b) => (distance(a.change) < distance(b.change) ? -1 : distance(a.change) > distance(b.change) ? 1 : 0));

/** One row per label for the carpet, smallest margin first. */
export function marginRows(margins: readonly ColorMargin[], judged: Judged): MarginRow[] {
  return ofSurface(margins, 'carpet').map(({ label, change }) => ({ label, change, kind: kindOf(change, judged), text: marginText('carpet', label, change) }));
}

/**
 * "floor becomes pink at +8 %" for each label with a thin margin to the floor beside the carpet, where it hides no
 * robot.
 */
export function floorTexts(margins: readonly ColorMargin[], judged: Judged): string[] {
  return ofSurface(margins, 'floor').filter(({ change }) => kindOf(change, judged) !== 'ok').map(({ label, change }) => marginText('floor', label, change));
}

/** The thinnest margin below the wanted one; null if there is none, or nothing is known. */
export function thinnest(state: ColorState | null): MarginRow | null {
  const first = state?.margins ? marginRows(state.margins, state)[0] : undefined;
  return first && first.kind !== 'ok' ? first : null;
}
