// SPDX-License-Identifier: Apache-2.0
// Carpet, lines and goals.
import type { FieldSize } from '../../../api/types';
import { fieldArcs, fieldLines } from '../../../geometry/fieldLines';
import { circle, lineTo, moveTo, tracePoints, type Pen } from './pen';

function rectangle(pen: Pen, half_x: number, half_y: number, r_px: number): void {
  const { ctx, view } = pen;
  const [w, h] = view.isUpright ? [half_y, half_x] : [half_x, half_y];
  ctx.beginPath();
  ctx.roundRect(view.width / 2 - w * view.scale, view.height / 2 - h * view.scale, 2 * w * view.scale, 2 * h * view.scale, r_px);
}

export function drawCarpet(pen: Pen, field: FieldSize): void {
  const { ctx, palette: { colours } } = pen;
  const { field_length, field_width, boundary_width } = field;
  rectangle(pen, field_length / 2 + boundary_width, field_width / 2 + boundary_width, 8);
  ctx.fillStyle = colours['--fld-edge'];
  ctx.fill();
  rectangle(pen, field_length / 2, field_width / 2, 0);
  ctx.fillStyle = colours['--fld'];
  ctx.fill();
}

export function drawLines(pen: Pen, field: FieldSize): void {
  const { ctx, view, palette: { colours } } = pen;
  ctx.beginPath();
  for (const { p1, p2 } of fieldLines(field)) tracePoints(pen, [p1, p2]);
  for (const points of fieldArcs(field)) tracePoints(pen, points);
  ctx.lineWidth = Math.max(1.2, field.line_thickness * view.scale);
  ctx.strokeStyle = colours['--fld-line'];
  ctx.stroke();

  ctx.beginPath();
  const [a, g] = [field.field_length / 2, field.goal_width / 2];
  for (const side of [1, -1]) {
    moveTo(pen, side * a, -g);
    lineTo(pen, side * (a + field.goal_depth), -g);
    lineTo(pen, side * (a + field.goal_depth), g);
    lineTo(pen, side * a, g);
  }
  ctx.lineWidth = 2.4;
  ctx.stroke();

  ctx.beginPath();
  const mark = field.goal_center_to_penalty_mark - field.field_length / 2;
  circle(pen, mark, 0, 2.2);
  circle(pen, -mark, 0, 2.2);
  ctx.fillStyle = colours['--fld-line'];
  ctx.fill();
}
