// SPDX-License-Identifier: Apache-2.0
// Mask polygons in image pixels. They may extend beyond the image.
import type { FieldSize } from '../../api/types';
import type { CameraModel, Point } from '../../geometry/cameraModel';

export type Kind = 'include' | 'exclude';
export type Pair = [number, number];
export interface Polygon {
  points: Pair[];
}
export interface Mask {
  include: Polygon[];
  exclude: Polygon[];
  beyond_boundary?: number | null;
}

export const FEWEST_CORNERS = 3;
/** Limits of the service, px. */
const LEAST = -16384;
const MOST = 32768;

const settled = (value: number) => Math.min(MOST, Math.max(LEAST, Math.round(value * 10) / 10));
export const pairOf = ({ x, y }: Point): Pair => [settled(x), settled(y)];
export const pointOf = ([x, y]: Pair): Point => ({ x, y });

/** A copy of a list with a part replaced. Array.toSpliced is too new for Node 18 and for older phones. */
export function spliced<T>(list: readonly T[], start: number, count: number, ...by: T[]): T[] {
  return [...list.slice(0, start), ...by, ...list.slice(start + count)];
}

export const withCorner = (polygon: Polygon, index: number, at: Point): Polygon => ({ points: polygon.points.map((point, i) => (i === index ? pairOf(at) : point)) });
/** Inserts a corner after corner `index`. */
export const withInserted = (polygon: Polygon, index: number, at: Point): Polygon => ({ points: spliced(polygon.points, index + 1, 0, pairOf(at)) });
export const withoutCorner = (polygon: Polygon, index: number): Polygon =>
  (polygon.points.length > FEWEST_CORNERS ? { points: spliced(polygon.points, index, 1) } : polygon);
export const shifted = (polygon: Polygon, dx: number, dy: number): Polygon => ({ points: polygon.points.map(([x, y]) => pairOf({ x: x + dx, y: y + dy })) });

/** Midpoints of the edges; the first one follows corner 0. */
export const middles = ({ points }: Polygon): Point[] => points.map(([x, y], i) => {
  const [nextX, nextY] = points[(i + 1) % points.length]!;
  return { x: (x + nextX) / 2, y: (y + nextY) / 2 };
});

/** An SVG path: adds half a pixel, because pixel centres are integers here. */
export const polygonPath = ({ points }: Polygon): string => `M${points.map(([x, y]) => `${x + 0.5} ${y + 0.5}`).join('L')}Z`;

/** Outline of the field and its boundary in a camera's image; null if a part of it is beyond the lens model's range. */
export function aroundField(model: CameraModel, field: FieldSize): Polygon | null {
  const a = field.field_length / 2 + field.boundary_width;
  const b = field.field_width / 2 + field.boundary_width;
  const corners: Pair[] = [[-a, -b], [a, -b], [a, b], [-a, b]];
  const PARTS = 6;
  const points: Pair[] = [];
  for (let side = 0; side < 4; side++) {
    const [x1, y1] = corners[side]!;
    const [x2, y2] = corners[(side + 1) % 4]!;
    for (let i = 0; i < PARTS; i++) {
      const pixel = model.project(x1 + ((x2 - x1) * i) / PARTS, y1 + ((y2 - y1) * i) / PARTS, 0);
      if (!pixel) return null;
      points.push(pairOf(pixel));
    }
  }
  return { points };
}
