// SPDX-License-Identifier: Apache-2.0
// How far a table's labels are from carpet and floor, for people.
import type { ColorMargin, ColorState } from '../../api/types';
import { decimal } from '../../format';

export type MarginKind = 'ok' | 'warn' | 'bad';

/** Where one label is nearest to a surface. */
export interface MarginRow {
  label: string;
  surface: ColorMargin['surface'];
  /** Of the light, as a share of it: 0.09 is brighter, -0.09 darker; null: it is nowhere near. */
  change: number | null;
  kind: MarginKind;
  text: string;
}

/** "carpet becomes green at +9 %" */
export function marginText(surface: string, label: string, change: number | null): string {
  if (change === null) return `carpet and floor never become ${label}`;
  const percent = Math.round(100 * Math.abs(change));
  if (percent === 0) return `${surface} is ${label} now`;
  return `${surface} becomes ${label} at ${change < 0 ? decimal(-percent, 0) : `+${percent}`} %`;
}

type Judged = Pick<ColorState, 'wanted_margin' | 'least_margin'>;
export function kindOf(change: number | null, { wanted_margin, least_margin }: Judged): MarginKind {
  const margin = change === null ? Infinity : Math.abs(change);
  return margin < least_margin ? 'bad' : margin < wanted_margin ? 'warn' : 'ok';
}

/** A row for each label, the least margin first. */
export function marginRows(margins: readonly ColorMargin[], judged: Judged): MarginRow[] {
  const rows = new Map<string, MarginRow>();
  for (const { label, surface, brighter, darker } of margins) {
    for (const change of [brighter, darker === null ? null : -darker]) {
      const before = rows.get(label);
      const nearer = before === undefined || (change !== null && Math.abs(change) < Math.abs(before.change ?? Infinity));
      if (nearer) rows.set(label, { label, surface, change, kind: kindOf(change, judged), text: marginText(surface, label, change) });
    }
  }
  return [...rows.values()].sort((a, b) => Math.abs(a.change ?? Infinity) - Math.abs(b.change ?? Infinity) || 0);
}

/** The thinnest of them that is too thin; null while none is, or nothing is known. */
export function thinnest(state: ColorState | null): MarginRow | null {
  const first = state?.margins ? marginRows(state.margins, state)[0] : undefined;
  return first && first.kind !== 'ok' ? first : null;
}
