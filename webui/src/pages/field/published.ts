// SPDX-License-Identifier: Apache-2.0
// Lines and arcs as in the geometry packets, each with its thickness.
import type { FieldSize } from '../../api/types';
import { fieldCurves, fieldLines } from '../../geometry/fieldLines';

export type LineRow = NonNullable<FieldSize['field_lines']>[number] & { thickness: number };
export type ArcRow = NonNullable<FieldSize['field_arcs']>[number] & { thickness: number };

/** 0 means the field's value. */
const thicknessOf = (field: FieldSize, own: number | null | undefined) => own || field.line_thickness;

export const publishedLines = (field: FieldSize): LineRow[] => fieldLines(field).map(({ name, p1, p2 }, i) => ({
  name, x1: p1.x, y1: p1.y, x2: p2.x, y2: p2.y, thickness: thicknessOf(field, field.field_lines?.[i]?.thickness),
}));

export const publishedArcs = (field: FieldSize): ArcRow[] => fieldCurves(field).map((arc, i) => ({
  ...arc, thickness: thicknessOf(field, field.field_arcs?.[i]?.thickness),
}));

/** An unused name. */
export function newName(kind: string, names: string[]): string {
  for (let i = names.length + 1; ; i++) {
    if (!names.includes(`${kind} ${i}`)) return `${kind} ${i}`;
  }
}
