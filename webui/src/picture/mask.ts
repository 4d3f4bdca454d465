// SPDX-License-Identifier: Apache-2.0
// What a camera's mask hides, as SVG paths with the even-odd rule.
import { turnPixel, type Size, type Turn } from '../geometry/turn';

export interface MaskPolygon {
  points: [number, number][];
}

/** A camera's "mask" in the settings. */
export interface MaskSettings {
  include: MaskPolygon[];
  exclude: MaskPolygon[];
}

/** Left, top, width and height, px; at pixel edges, not centres. */
export type Rectangle = [number, number, number, number];

export interface MaskPaths {
  /** Only the inside of these is searched; none: everything. */
  include: string[];
  exclude: string[];
  /** Areas too far beyond the field; '': none. */
  beyond: string;
}

const round = (value: number) => Math.round(value * 10) / 10;

/** A rectangle's corners as a polygon in pixel-centre coordinates. */
const cornersOf = ([left, top, width, height]: Rectangle): MaskPolygon => {
  const [x1, y1, x2, y2] = [left - 0.5, top - 0.5, left + width - 0.5, top + height - 0.5];
  return { points: [[x1, y1], [x2, y1], [x2, y2], [x1, y2]] };
};

/** An SVG path over an image that is not turned. */
export const rectanglesPath = (rectangles: Rectangle[]): string => rectangles.map(([left, top, width, height]) => `M${left} ${top}h${width}v${height}h${-width}Z`).join('');

/** Null if nothing is hidden. */
export function maskPaths(mask: MaskSettings | null | undefined, hidden: Rectangle[], picture: Size, turn: Turn): MaskPaths | null {
  const { include, exclude } = mask ?? { include: [], exclude: [] };
  if (include.length + exclude.length + hidden.length === 0) return null;
  const path = ({ points }: MaskPolygon) => {
    const corners = points.map(([x, y]) => turnPixel(turn, picture, { x, y }));
    return `M${corners.map(({ x, y }) => `${round(x)} ${round(y)}`).join('L')}Z`;
  };
  return { include: include.map(path), exclude: exclude.map(path), beyond: hidden.map((one) => path(cornersOf(one))).join('') };
}
