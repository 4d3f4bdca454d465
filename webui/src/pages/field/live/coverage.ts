// SPDX-License-Identifier: Apache-2.0
// The number of cameras that see each part of the field.
import type { CameraStatus, FieldSize, Status } from '../../../api/types';
import type { Point } from '../../../geometry/cameraModel';
import { coverage as outlineOf } from '../../../geometry/outline';

export interface Outline { camera: number; points: Point[] }
export interface CoverageMap {
  outlines: Outline[];
  side_mm: number;
  /** Centres of squares. The service reports the uncovered ones, because it knows what masks hide. */
  squares: { x: number; y: number; count: number }[];
}

export const outlinesOf = (cameras: readonly CameraStatus[]): Outline[] =>
  cameras.map((camera) => ({ camera: camera.id, points: outlineOf(camera) })).filter(({ points }) => points.length > 2);

/** Whether a place lies inside a polygon. */
export function isInside({ x, y }: Point, polygon: readonly Point[]): boolean {
  let inside = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [a, b] = [polygon[i]!, polygon[j]!];
    if ((a.y > y) !== (b.y > y) && x < a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

const keyOf = (x: number, y: number) => `${Math.round(x)} ${Math.round(y)}`;

export function coverageMap(field: FieldSize, cameras: readonly CameraStatus[], { grid_mm: side, uncovered }: Status['coverage']): CoverageMap {
  const outlines = outlinesOf(cameras);
  const holes = new Set(uncovered.map(([x = 0, y = 0]) => keyOf(x, y)));
  const squares = [];
  for (let x = (side - field.field_length) / 2; x < field.field_length / 2; x += side) {
    for (let y = (side - field.field_width) / 2; y < field.field_width / 2; y += side) {
      const count = holes.has(keyOf(x, y)) ? 0 : outlines.filter(({ points }) => isInside({ x, y }, points)).length;
      squares.push({ x, y, count });
    }
  }
  return { outlines, side_mm: side, squares };
}

/** Percentage of the field for each number of cameras, ascending: [{count, percent}]. */
export function sharesOf({ squares }: CoverageMap): { count: number; percent: number }[] {
  const counts = [...new Set(squares.map(({ count }) => count))].sort((a, b) => a - b);
  return counts.map((count) => ({ count, percent: (100 * squares.filter((square) => square.count === count).length) / squares.length }));
}
