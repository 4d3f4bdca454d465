// SPDX-License-Identifier: Apache-2.0
// Display colours of the labels: kNames and kDisplayColors in daemon/vision/label.h.
import type { Rgb } from './exposure';

export const labelColours: Readonly<Record<string, Rgb>> = {
  clear: [52, 54, 58],
  field: [40, 124, 70],
  orange: [255, 138, 31],
  yellow: [255, 212, 0],
  blue: [58, 116, 255],
  pink: [255, 84, 166],
  cyan: [60, 214, 240],
  green: [52, 226, 124],
  white: [233, 237, 242],
  black: [0, 0, 0],
};

/** The label of a pixel of the labelled image: that of the nearest colour, because JPEG alters colours slightly. */
export function labelOf([r, g, b]: Rgb): string {
  const distance = ([lr, lg, lb]: Rgb) => (lr - r) ** 2 + (lg - g) ** 2 + (lb - b) ** 2;
  return Object.entries(labelColours).reduce((best, one) => (distance(one[1]) < distance(best[1]) ? one : best))[0];
}
