// SPDX-License-Identifier: Apache-2.0
// The field's lines: its own ones, or computed from its sizes, with the league's names and positions.
import type { FieldSize } from '../api/types';
import type { Point } from './cameraModel';

export interface FieldLine {
  name: string;
  p1: Point;
  p2: Point;
}

const line = (name: string, x1: number, y1: number, x2: number, y2: number): FieldLine => ({
  name, p1: { x: x1, y: y1 }, p2: { x: x2, y: y2 },
});

export function fieldLines(field: FieldSize): FieldLine[] {
  if (field.field_lines) return field.field_lines.map((l) => line(l.name, l.x1, l.y1, l.x2, l.y2));
  const a = field.field_length / 2;
  const b = field.field_width / 2;
  const px = a - field.penalty_area_depth;
  const py = field.penalty_area_width / 2;
  const lines = [
    line('TopTouchLine', -a, b, a, b),
    line('BottomTouchLine', -a, -b, a, -b),
    line('LeftGoalLine', -a, -b, -a, b),
    line('RightGoalLine', a, -b, a, b),
    line('HalfwayLine', 0, -b, 0, b),
    line('CenterLine', -a, 0, a, 0),
  ];
  if (field.penalty_area_depth <= 0 || field.penalty_area_width <= 0) return lines;
  return [
    ...lines,
    line('LeftPenaltyStretch', -px, -py, -px, py),
    line('RightPenaltyStretch', px, -py, px, py),
    line('LeftFieldLeftPenaltyStretch', -a, -py, -px, -py),
    line('LeftFieldRightPenaltyStretch', -a, py, -px, py),
    line('RightFieldLeftPenaltyStretch', a, py, px, py),
    line('RightFieldRightPenaltyStretch', a, -py, px, -py),
  ];
}

/** Lines every metre across the field and its boundary, measured from the centre. */
export function gridLines(field: FieldSize, step = 1000): FieldLine[] {
  const a = field.field_length / 2 + field.boundary_width;
  const b = field.field_width / 2 + field.boundary_width;
  const lines: FieldLine[] = [];
  for (let x = -Math.floor(a / step) * step; x <= a; x += step) lines.push(line(`x ${x}`, x, -b, x, b));
  for (let y = -Math.floor(b / step) * step; y <= b; y += step) lines.push(line(`y ${y}`, -a, y, a, y));
  return lines;
}

export function arc(centre: Point, radius: number, a1 = 0, a2 = 2 * Math.PI, corners = 72): Point[] {
  return Array.from({ length: corners + 1 }, (_, i) => {
    const angle = a1 + (i / corners) * (a2 - a1);
    return { x: centre.x + radius * Math.cos(angle), y: centre.y + radius * Math.sin(angle) };
  });
}

export type FieldArc = Omit<NonNullable<FieldSize['field_arcs']>[number], 'thickness'>;

export function fieldCurves(field: FieldSize): FieldArc[] {
  if (field.field_arcs) return field.field_arcs;
  if (field.center_circle_radius <= 0) return [];
  return [{ name: 'CenterCircle', x: 0, y: 0, radius: field.center_circle_radius, a1: 0, a2: 2 * Math.PI }];
}

/** The field's arcs as polylines. */
export const fieldArcs = (field: FieldSize): Point[][] =>
  fieldCurves(field).map(({ x, y, radius, a1, a2 }) => arc({ x, y }, radius, a1, a2));

/** Points along a line, dense enough to show the lens distortion. */
export function alongLine({ p1, p2 }: FieldLine, step = 100): Point[] {
  const parts = Math.max(1, Math.ceil(Math.hypot(p2.x - p1.x, p2.y - p1.y) / step));
  return Array.from({ length: parts + 1 }, (_, i) => ({
    x: p1.x + ((p2.x - p1.x) * i) / parts,
    y: p1.y + ((p2.y - p1.y) * i) / parts,
  }));
}

/** "Division B · 9 × 6 m" */
export function fieldTitle(field: FieldSize): string {
  const metres = (mm: number) => String(Math.round(mm / 10) / 100);
  const size = `${metres(field.field_length)} × ${metres(field.field_width)} m`;
  if (field.field_length === 12000 && field.field_width === 9000) return `Division A · ${size}`;
  if (field.field_length === 9000 && field.field_width === 6000) return `Division B · ${size}`;
  return `Field · ${size}`;
}
