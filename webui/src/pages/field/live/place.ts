// SPDX-License-Identifier: Apache-2.0
// Converts field to canvas coordinates: +x to the right and +y up; on a canvas that is higher than wide, +x up.
import type { FieldSize } from '../../../api/types';

export interface View {
  /** CSS pixels of the canvas. */
  width: number;
  height: number;
  /** CSS pixels per millimetre. */
  scale: number;
  isUpright: boolean;
}

/** The field is drawn upright if the canvas is higher than this times its width. */
const UPRIGHT = 1.15;

/** Fits the field with its boundary into a canvas. */
export function viewOf(field: FieldSize, width: number, height: number): View {
  const long = field.field_length + 2 * field.boundary_width;
  const short = field.field_width + 2 * field.boundary_width;
  const isUpright = height > UPRIGHT * width;
  const [across, up] = isUpright ? [short, long] : [long, short];
  return { width, height, scale: Math.max(1e-6, Math.min(width / across, height / up)), isUpright };
}

export const leftOf = (view: View, x: number, y: number): number => view.width / 2 + view.scale * (view.isUpright ? -y : x);
export const topOf = (view: View, x: number, y: number): number => view.height / 2 - view.scale * (view.isUpright ? x : y);
/** Converts an angle of the field to the canvas: clockwise from the right. */
export const angleOn = (view: View, angle: number): number => -(view.isUpright ? angle + Math.PI / 2 : angle);
