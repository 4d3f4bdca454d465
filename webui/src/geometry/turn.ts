// SPDX-License-Identifier: Apache-2.0
// Quarter turns that orient an image like the field: +x to the right, +y up.
import type { CameraStatus } from '../api/types';
import { CameraModel, type Point } from './cameraModel';

/** Quarter turns clockwise. */
export type Turn = 0 | 1 | 2 | 3;

export interface Size {
  width: number;
  height: number;
}

export function turnedSize(turn: Turn, { width, height }: Size): Size {
  return turn % 2 ? { width: height, height: width } : { width, height };
}

/**
 * Converts a pixel of the camera's image to a position in the turned image. Pixel centres are integers, while drawing
 * coordinates start at the image's corner, half a pixel before them.
 */
export function turnPixel(turn: Turn, { width, height }: Size, pixel: Point): Point {
  const x = pixel.x + 0.5;
  const y = pixel.y + 0.5;
  switch (turn) {
    case 0: return { x, y };
    case 1: return { x: height - y, y: x };
    case 2: return { x: width - x, y: height - y };
    case 3: return { x: y, y: width - x };
  }
}

/** Inverse of turnPixel(): the camera's pixel at a position in the turned image. */
export function unturnPixel(turn: Turn, { width, height }: Size, { x, y }: Point): Point {
  switch (turn) {
    case 0: return { x: x - 0.5, y: y - 0.5 };
    case 1: return { x: y - 0.5, y: height - x - 0.5 };
    case 2: return { x: width - x - 0.5, y: height - y - 0.5 };
    case 3: return { x: width - y - 0.5, y: x - 0.5 };
  }
}

/** The turn that brings the field's +x closest to the right of the image. */
export function fieldTurn(camera: CameraModel | null, { width, height }: Size): Turn {
  const middle = camera?.unproject(width / 2, height / 2, 0);
  if (!camera || !middle) return 0;
  const from = camera.project(middle.x - 100, middle.y, 0);
  const to = camera.project(middle.x + 100, middle.y, 0);
  if (!from || !to) return 0;
  const angle = Math.atan2(to.y - from.y, to.x - from.x);
  return (((Math.round(-angle / (Math.PI / 2)) % 4) + 4) % 4) as Turn;
}

export function cameraTurn(camera: CameraStatus): Turn {
  return fieldTurn(camera.calibration ? new CameraModel(camera.calibration) : null, camera);
}
