// SPDX-License-Identifier: Apache-2.0
import { turnedSize, type Turn } from '../geometry/turn';

/**
 * Draws an image on a canvas and gives the canvas the turned size. Quarter turns move whole pixels: nothing is
 * smoothed.
 */
export function drawTurned(canvas: HTMLCanvasElement, context: CanvasRenderingContext2D, picture: ImageBitmap | OffscreenCanvas, turn: Turn): void {
  const { width, height } = turnedSize(turn, picture);
  // Setting a canvas' size clears it, so it is set only when it differs.
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  context.imageSmoothingEnabled = false;
  context.setTransform(1, 0, 0, 1, width / 2, height / 2);
  context.rotate((turn * Math.PI) / 2);
  context.drawImage(picture, -picture.width / 2, -picture.height / 2);
}
