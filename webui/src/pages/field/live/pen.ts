// SPDX-License-Identifier: Apache-2.0
// Functions shared by the drawings of the field.
import type { FieldSize } from '../../../api/types';
import type { Point } from '../../../geometry/cameraModel';
import { angleOn, leftOf, topOf, type View } from './place';
import { fontOf, type Palette } from './palette';

export interface Pen {
  ctx: CanvasRenderingContext2D;
  view: View;
  palette: Palette;
}

export function moveTo({ ctx, view }: Pen, x: number, y: number): void { ctx.moveTo(leftOf(view, x, y), topOf(view, x, y)); }
export function lineTo({ ctx, view }: Pen, x: number, y: number): void { ctx.lineTo(leftOf(view, x, y), topOf(view, x, y)); }

export function tracePoints(pen: Pen, points: readonly Point[]): void {
  points.forEach(({ x, y }, i) => (i ? lineTo : moveTo)(pen, x, y));
}

export function circle({ ctx, view }: Pen, x: number, y: number, r_px: number): void {
  const left = leftOf(view, x, y);
  const top = topOf(view, x, y);
  ctx.moveTo(left + r_px, top);
  ctx.arc(left, top, r_px, 0, 2 * Math.PI);
}

/** Robots are drawn to scale if their numbers fit, else larger, but not too large for small fields on a phone. */
export function robotRadius({ view, palette: { type_px } }: Pen, field: FieldSize): number {
  const nature = field.max_robot_radius * view.scale;
  return Math.max(nature, Math.min(type_px, Math.max(0.8 * type_px, 1.8 * nature)));
}
export const ballRadius = ({ view }: Pen, field: FieldSize): number => Math.max(field.ball_radius * view.scale, 4.5);

/** Half of the angle of the flat front, rad. */
export const FRONT = 0.56;

/** `orientation` NaN: unknown. */
export function robotBody({ ctx, view }: Pen, x: number, y: number, orientation: number, r_px: number): void {
  const left = leftOf(view, x, y);
  const top = topOf(view, x, y);
  if (Number.isNaN(orientation)) {
    ctx.moveTo(left + r_px, top);
    ctx.arc(left, top, r_px, 0, 2 * Math.PI);
    return;
  }
  const angle = angleOn(view, orientation);
  ctx.moveTo(left + r_px * Math.cos(angle + FRONT), top + r_px * Math.sin(angle + FRONT));
  ctx.arc(left, top, r_px, angle + FRONT, angle - FRONT + 2 * Math.PI);
  ctx.closePath();
}

/** An arrow from one point of the canvas to another. */
export function arrow({ ctx }: Pen, x1: number, y1: number, x2: number, y2: number, head = 5): void {
  const angle = Math.atan2(y2 - y1, x2 - x1);
  ctx.moveTo(x1, y1);
  ctx.lineTo(x2, y2);
  for (const side of [2.6, -2.6]) {
    ctx.moveTo(x2, y2);
    ctx.lineTo(x2 + head * Math.cos(angle + side), y2 + head * Math.sin(angle + side));
  }
}

/** Text with a halo, readable on any background. */
export function label({ ctx, palette }: Pen, text: string, left: number, top: number, colour: string, halo = palette.colours['--fld'], halo_px = 3.5): void {
  ctx.lineJoin = 'round';
  ctx.lineWidth = halo_px;
  ctx.strokeStyle = halo;
  ctx.strokeText(text, left, top);
  ctx.fillStyle = colour;
  ctx.fillText(text, left, top);
}

export function setType({ ctx, palette }: Pen, times = 1): void {
  ctx.font = fontOf(palette, times);
  ctx.textAlign = 'center';
  ctx.textBaseline = 'middle';
}
