// SPDX-License-Identifier: Apache-2.0
// Reports of single cameras, each in its colour. Rings of several cameras around one robot are concentric.
import type { FieldSize } from '../../../api/types';
import { idText } from '../../../picture/marks';
import { bandOf } from './agreement';
import { BODY, BODY_INK } from './palette';
import { ballRadius, circle, label, robotBody, robotRadius, setType, type Pen } from './pen';
import { angleOn, leftOf, topOf } from './place';
import { colourOfCamera, OLD_MS, type Apart, type OfCamera } from './raw';
import { apartText } from './words';

const RING_PX = 3.5;
/** Balls of two cameras closer than about this count as one. */
const BALL_MM = 200;

export function drawRaw(pen: Pen, field: FieldSize, cameras: readonly OfCamera[], differences: readonly Apart[], now: number): void {
  const { ctx, view, palette } = pen;
  const { colours, type_px } = palette;
  const r = robotRadius(pen, field);

  // Bodies first: the rings of all cameras stay readable above them.
  for (const team of ['yellow', 'blue'] as const) {
    ctx.beginPath();
    for (const { detections } of cameras) for (const one of detections.robots) if (one.team === team) robotBody(pen, one.x, one.y, one.orientation, r - 1);
    ctx.fillStyle = BODY[team];
    ctx.fill();
    ctx.fillStyle = BODY_INK[team];
    setType(pen);
    for (const { detections } of cameras) for (const one of detections.robots) if (one.team === team) ctx.fillText(idText(one.id), leftOf(view, one.x, one.y), topOf(view, one.x, one.y) + 0.5);
  }
  ctx.beginPath();
  for (const { detections } of cameras) for (const { x, y } of detections.balls) circle(pen, x, y, ballRadius(pen, field) - 0.5);
  ctx.fillStyle = colours['--ball'];
  ctx.fill();

  /** Number of rings already drawn around an object. */
  const rings = new Map<string, number>();
  const place = (key: string) => {
    const before = rings.get(key) ?? 0;
    rings.set(key, before + 1);
    return before;
  };
  for (const { camera, detections, at } of cameras) {
    const isOld = now - at > OLD_MS;
    const colour = colours[colourOfCamera(camera)];
    ctx.globalAlpha = isOld ? 0.45 : 1;
    ctx.setLineDash(isOld ? [4, 3] : []);
    ctx.strokeStyle = colour;
    ctx.lineWidth = 2;
    const numbers: [left: number, top: number][] = [];
    /** Camera numbers are placed around the reported object, one position each. */
    const number = (left: number, top: number, ring: number, at_place: number) => {
      const angle = -0.8 + 1.1 * at_place;
      const away = ring + 0.65 * type_px;
      numbers.push([left + away * Math.cos(angle), top + away * Math.sin(angle)]);
    };
    ctx.beginPath();
    for (const { team, id, x, y, orientation } of detections.robots) {
      const at_place = place(`${team} ${id}`);
      const ring = r + 1.5 + RING_PX * at_place;
      circle(pen, x, y, ring);
      const angle = angleOn(view, orientation);
      const [left, top] = [leftOf(view, x, y), topOf(view, x, y)];
      if (!Number.isNaN(angle)) {
        ctx.moveTo(left + ring * Math.cos(angle), top + ring * Math.sin(angle));
        ctx.lineTo(left + (ring + 6) * Math.cos(angle), top + (ring + 6) * Math.sin(angle));
      }
      number(left, top, ring, at_place);
    }
    for (const { x, y } of detections.balls) {
      const at_place = place(`ball ${Math.round(x / BALL_MM)} ${Math.round(y / BALL_MM)}`);
      const ring = ballRadius(pen, field) + 2.5 + RING_PX * at_place;
      circle(pen, x, y, ring);
      number(leftOf(view, x, y), topOf(view, x, y), ring, at_place);
    }
    ctx.stroke();
    ctx.setLineDash([]);
    setType(pen);
    for (const [left, top] of numbers) label(pen, String(camera), left, top, colour);
    ctx.globalAlpha = 1;
  }

  setType(pen);
  for (const { team, id, x, y, dx, dy } of differences) {
    const below = r + RING_PX * (rings.get(`${team} ${id}`) ?? 1) + 0.8 * type_px;
    const mm = Math.hypot(dx, dy);
    const [left, top] = [leftOf(view, x, y), topOf(view, x, y)];
    const isLow = top + below + type_px > view.height;
    label(pen, apartText(mm), left, top + (isLow ? -below : below), mm < bandOf(0).below_mm ? colours['--t2'] : colours['--t1']);
  }
}
