// SPDX-License-Identifier: Apache-2.0
// Points of the field that the user marked in the image, and values known before a calibration.
import type { CalibrationReport, CalibrationRequest, CalibrationState, FieldPoint } from '../../api/types';
import type { CameraModel, Point } from '../../geometry/cameraModel';
import type { Size } from '../../geometry/turn';

/** A point in the image; the service finds the name if it is empty. */
export interface Corner extends Point {
  name: string;
}

/** Four points determine a camera's pose. The service accepts three, with which it finds the pose less often. */
export const FEWEST_POINTS = 4;

export interface Known {
  height_mm: number | null;
  height_sigma_mm: number;
  focal_px: number | null;
  plus_x: CalibrationRequest['plus_x'] | null;
  lines_measured_to: CalibrationRequest['lines_measured_to'] | null;
}

export const NOTHING_KNOWN: Known = { height_mm: null, height_sigma_mm: 20, focal_px: null, plus_x: null, lines_measured_to: null };

/** Pixel centres are integers, so the image extends half a pixel beyond the last one. */
export const isInside = ({ x, y }: Point, { width, height }: Size) => x >= -0.5 && y >= -0.5 && x <= width - 0.5 && y <= height - 0.5;

export const clampInto = ({ x, y }: Point, { width, height }: Size): Point => ({
  x: Math.min(width - 1, Math.max(0, x)), y: Math.min(height - 1, Math.max(0, y)),
});

const tenths = (value: number) => Math.round(value * 10) / 10;

/** Image positions of the field's points that a camera sees. */
export function seenPoints(model: CameraModel, named: FieldPoint[], size: Size): Corner[] {
  return named.flatMap(({ name, field_x, field_y }) => {
    const pixel = model.project(field_x, field_y, 0);
    return pixel && isInside(pixel, size) ? [{ name, x: tenths(pixel.x), y: tenths(pixel.y) }] : [];
  });
}

/** The points of a finished calibration: the given ones with the names found, else the detected ones. */
export function pointsOf(report: CalibrationReport, size: Size): Corner[] {
  const points = report.points.length ? report.points : report.control_points.filter((point) => isInside(point, size));
  return points.map(({ name, x, y }) => ({ name, x: tenths(x), y: tenths(y) }));
}

export function knownOf(request: CalibrationState['request']): Known {
  if (!request) return NOTHING_KNOWN;
  return {
    height_mm: request.height_mm ?? null,
    height_sigma_mm: request.height_sigma_mm ?? NOTHING_KNOWN.height_sigma_mm,
    focal_px: request.focal_px ?? null,
    plus_x: request.plus_x ?? null,
    lines_measured_to: request.lines_measured_to ?? null,
  };
}

/** Sends only known values. */
export function requestOf(points: Corner[], known: Known, force: boolean): CalibrationRequest {
  const request: CalibrationRequest = { points: points.map(({ name, x, y }) => (name ? { name, x, y } : { x, y })), force };
  if (known.height_mm !== null) Object.assign(request, { height_mm: known.height_mm, height_sigma_mm: known.height_sigma_mm });
  if (known.focal_px !== null) request.focal_px = known.focal_px;
  if (known.plus_x) request.plus_x = known.plus_x;
  if (known.lines_measured_to) request.lines_measured_to = known.lines_measured_to;
  return request;
}

/** "height 4000 mm, focal length 460 px" */
export function knownText(known: Known): string {
  const words: string[] = [];
  if (known.height_mm !== null) words.push(`height ${known.height_mm} mm`);
  if (known.focal_px !== null) words.push(`focal length ${known.focal_px} px`);
  if (known.plus_x) words.push(`+x ${known.plus_x}`);
  if (known.lines_measured_to) words.push(known.lines_measured_to === 'middle' ? 'sizes to line centres' : 'sizes to line edges');
  return words.length ? words.join(', ') : 'nothing given';
}

/** Whether the service asks where +x is, because the image does not distinguish the two halves of the field. */
export const asksForPlusX = (report: CalibrationReport | null): boolean => report?.notes.some((note) => note.includes('say where +x is')) ?? false;
/** Whether it asks for the camera's height, because the lines do not determine it. */
export const asksForHeight = (report: CalibrationReport | null): boolean => report?.notes.some((note) => note.startsWith("The camera's height")) ?? false;
