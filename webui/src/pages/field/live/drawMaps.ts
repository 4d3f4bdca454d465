// SPDX-License-Identifier: Apache-2.0
// Maps on the carpet: distances between cameras' positions, and number of cameras per square.
import { arrowOf, bandOf, type Square } from './agreement';
import type { CoverageMap } from './coverage';
import { arrow, label, setType, tracePoints, type Pen } from './pen';
import { angleOn, leftOf, topOf } from './place';
import { colourOfCamera } from './raw';

/** Differences from here on are shown as a number. */
const NUMBER_MM = 5;

export function drawAgreement(pen: Pen, squares: readonly Square[], part_mm: number): void {
  const { ctx, view, palette: { colours, type_px } } = pen;
  const side = part_mm * view.scale;
  for (const { x, y, mm, isOld } of squares) {
    ctx.globalAlpha = isOld ? 0.3 : 0.85;
    ctx.fillStyle = colours[bandOf(mm).colour];
    ctx.fillRect(leftOf(view, x, y) - side / 2 + 0.5, topOf(view, x, y) - side / 2 + 0.5, side - 1, side - 1);
  }
  ctx.globalAlpha = 1;
  setType(pen);
  for (const { x, y, pairs, mm, isOld } of squares) {
    const [left, top] = [leftOf(view, x, y), topOf(view, x, y)];
    ctx.globalAlpha = isOld ? 0.45 : 1;
    ctx.beginPath();
    for (const pair of pairs) {
      const { dx, dy } = arrowOf(pair);
      const [toLeft, toTop] = [leftOf(view, x + dx, y + dy), topOf(view, x + dx, y + dy)];
      if (Math.hypot(toLeft - left, toTop - top) < 2) { ctx.moveTo(left + 1.5, top); ctx.arc(left, top, 1.5, 0, 2 * Math.PI); }
      else arrow(pen, left, top, toLeft, toTop, Math.min(4.5, 1.5 + 0.4 * Math.hypot(toLeft - left, toTop - top)));
    }
    // Dark on light: an arrow must contrast with every colour of the scale.
    ctx.lineCap = 'round';
    ctx.strokeStyle = '#fffc';
    ctx.lineWidth = 3;
    ctx.stroke();
    ctx.strokeStyle = '#10151a';
    ctx.lineWidth = 1.5;
    ctx.stroke();
    ctx.lineCap = 'butt';
    if (mm < NUMBER_MM || side < 2.4 * type_px) continue;
    // On the side opposite to the arrow.
    const angle = angleOn(view, Math.atan2(pairs[0]!.off_y_mm, pairs[0]!.off_x_mm));
    label(pen, mm.toFixed(0), left - 0.27 * side * Math.cos(angle), top - 0.27 * side * Math.sin(angle), '#10151a', '#fff9');
  }
  ctx.globalAlpha = 1;
}

const COUNT_ALPHA = [0, 0.1, 0.34, 0.52, 0.68] as const;
export const alphaOfCount = (count: number): number => COUNT_ALPHA[Math.min(count, COUNT_ALPHA.length - 1)]!;

export function drawCoverage(pen: Pen, { squares, side_mm }: CoverageMap): void {
  const { ctx, view, palette: { colours } } = pen;
  const side = side_mm * view.scale;
  ctx.fillStyle = colours['--g1'];
  for (const { x, y, count } of squares) {
    if (!count) continue;
    ctx.globalAlpha = alphaOfCount(count);
    const [left, top] = [leftOf(view, x, y) - side / 2, topOf(view, x, y) - side / 2];
    // Whole pixels: seams between squares would look like field lines.
    ctx.fillRect(Math.round(left), Math.round(top), Math.round(left + side) - Math.round(left), Math.round(top + side) - Math.round(top));
  }
  ctx.globalAlpha = 1;
  const holes = squares.filter(({ count }) => count === 0);
  if (!holes.length) return;
  ctx.save();
  ctx.beginPath();
  for (const { x, y } of holes) ctx.rect(leftOf(view, x, y) - side / 2, topOf(view, x, y) - side / 2, side, side);
  ctx.clip();
  ctx.beginPath();
  for (let at = -view.height; at < view.width; at += 8) {
    ctx.moveTo(at, view.height);
    ctx.lineTo(at + view.height, 0);
  }
  ctx.strokeStyle = colours['--warn'];
  ctx.lineWidth = 2;
  ctx.globalAlpha = 0.7;
  ctx.stroke();
  ctx.restore();
}

/** Distance between two figures. */
const FIGURE_MM = 1000;

/** Outlines of cameras, and the number of cameras that see a place: drawn above the field's lines. */
export function drawCoverageFigures(pen: Pen, { outlines, squares, side_mm }: CoverageMap): void {
  const { ctx, view, palette: { colours, type_px } } = pen;
  outlines.forEach(({ camera, points }, i) => {
    ctx.beginPath();
    tracePoints(pen, points);
    ctx.closePath();
    ctx.strokeStyle = colours[colourOfCamera(camera)];
    ctx.lineWidth = 2;
    ctx.setLineDash([7, 5]);
    // Overlapping outlines show both colours.
    ctx.lineDashOffset = 6 * i;
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.lineDashOffset = 0;
  });
  setType(pen);
  const every = Math.max(1, Math.round(FIGURE_MM / side_mm), Math.ceil((2.4 * type_px) / (side_mm * view.scale)));
  const xs = [...new Set(squares.map(({ x }) => x))].sort((a, b) => a - b);
  const ys = [...new Set(squares.map(({ y }) => y))].sort((a, b) => a - b);
  const isShown = (all: number[], at: number) => all.indexOf(at) % every === Math.floor(every / 2);
  for (const { x, y, count } of squares) {
    if (isShown(xs, x) && isShown(ys, y)) label(pen, String(count), leftOf(view, x, y), topOf(view, x, y), colours[count ? '--t2' : '--warn'], colours['--fld'], count ? 3.5 : 8);
  }
  setType(pen, 1.1);
  for (const { camera, points } of outlines) {
    const x = points.reduce((sum, point) => sum + point.x, 0) / points.length;
    const y = points.reduce((sum, point) => sum + point.y, 0) / points.length;
    const text = `Camera ${camera}`;
    const half = ctx.measureText(text).width / 2 + 8;
    const left = Math.min(view.width - half, Math.max(half, leftOf(view, x, y)));
    const top = Math.min(view.height - 14, Math.max(14, topOf(view, x, y)));
    ctx.beginPath();
    ctx.roundRect(left - half, top - 12, 2 * half, 24, 12);
    ctx.fillStyle = colours['--s-1'];
    ctx.fill();
    ctx.strokeStyle = colours[colourOfCamera(camera)];
    ctx.lineWidth = 2;
    ctx.stroke();
    ctx.fillStyle = colours['--t1'];
    ctx.fillText(text, left, top + 0.5);
  }
}
