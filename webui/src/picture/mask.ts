// SPDX-License-Identifier: Apache-2.0
// What a camera's mask leaves out, as SVG paths. Inside a polygon is decided by the even-odd rule.
import { turnPixel, type Size, type Turn } from '../geometry/turn';

export interface MaskPolygon {
  points: [number, number][];
}

/** A camera's "mask" in the settings. */
export interface MaskSettings {
  include: MaskPolygon[];
  exclude: MaskPolygon[];
}

export interface MaskPaths {
  /** Only what lies in one of these is looked at; none: everything. */
  include: string[];
  exclude: string[];
}

const round = (value: number) => Math.round(value * 10) / 10;

/** null when nothing is left out. */
export function maskPaths(mask: MaskSettings | null | undefined, picture: Size, turn: Turn): MaskPaths | null {
  if (!mask || mask.include.length + mask.exclude.length === 0) return null;
  const path = ({ points }: MaskPolygon) => {
    const corners = points.map(([x, y]) => turnPixel(turn, picture, { x, y }));
    return `M${corners.map(({ x, y }) => `${round(x)} ${round(y)}`).join('L')}Z`;
  };
  return { include: mask.include.map(path), exclude: mask.exclude.map(path) };
}
