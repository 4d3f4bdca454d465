// SPDX-License-Identifier: Apache-2.0
// Field shapes as SVG paths in a camera's (turned) image.
import type { CameraStatus, FieldSize } from '../api/types';
import { CameraModel, type Point } from './cameraModel';
import { alongLine, fieldArcs, fieldLines, gridLines } from './fieldLines';
import { turnPixel, type Size, type Turn } from './turn';

/** Rounds to 0.1 px: fine enough for a line, and keeps paths short. */
const round = (value: number) => Math.round(value * 10) / 10;

/** A path through points on the floor; it is interrupted where the camera cannot see them. */
function floorPath(model: CameraModel, camera: Size, turn: Turn, points: Point[]): string {
  const margin = camera.width;
  let path = '';
  let drawing = false;
  for (const point of points) {
    const pixel = model.project(point.x, point.y, 0);
    const near = pixel && pixel.x > -margin && pixel.x < camera.width + margin
      && pixel.y > -margin && pixel.y < camera.height + margin;
    if (!near) {
      drawing = false;
      continue;
    }
    const { x, y } = turnPixel(turn, camera, pixel);
    path += `${drawing ? 'L' : 'M'}${round(x)} ${round(y)}`;
    drawing = true;
  }
  return path;
}

export function linesPath(model: CameraModel, camera: Size, turn: Turn, field: FieldSize): string {
  const shapes = [...fieldLines(field).map((l) => alongLine(l)), ...fieldArcs(field)];
  return shapes.map((points) => floorPath(model, camera, turn, points)).join('');
}

export function gridPath(model: CameraModel, camera: Size, turn: Turn, field: FieldSize): string {
  return gridLines(field).map((l) => floorPath(model, camera, turn, alongLine(l))).join('');
}

/** The part of the floor that a camera sees, as a polygon in field coordinates, mm. */
export function coverage(camera: CameraStatus): Point[] {
  if (!camera.calibration) return [];
  const model = new CameraModel(camera.calibration);
  const right = camera.width - 1;
  const bottom = camera.height - 1;
  const corners = [[0, 0], [right, 0], [right, bottom], [0, bottom]] as const;
  const parts = 8;
  const points: Point[] = [];
  for (let side = 0; side < 4; side++) {
    const [x1, y1] = corners[side]!;
    const [x2, y2] = corners[(side + 1) % 4]!;
    for (let i = 0; i < parts; i++) {
      const point = model.unproject(x1 + ((x2 - x1) * i) / parts, y1 + ((y2 - y1) * i) / parts, 0);
      if (!point) return [];
      points.push(point);
    }
  }
  return points;
}
