// SPDX-License-Identifier: Apache-2.0
// A frame's regions as SVG paths, one for each label.
import type { PreviewRegions } from '../api/types';
import { turnPixel, type Size, type Turn } from '../geometry/turn';
import { labelColours } from './labels';

export interface RegionPath {
  label: string;
  colour: string;
  path: string;
}

/** Boxes around whole pixels, in pixels of the (turned) image. */
export function regionPaths(regions: PreviewRegions | null | undefined, picture: Size, turn: Turn): RegionPath[] {
  const paths = new Map<string, string>();
  for (const [index, x, y, width, height] of regions?.boxes ?? []) {
    const label = regions!.labels[index!] ?? '';
    // turnPixel() expects pixel centres, half a pixel from their corner; these are corners.
    const a = turnPixel(turn, picture, { x: x! - 0.5, y: y! - 0.5 });
    const b = turnPixel(turn, picture, { x: x! + width! - 0.5, y: y! + height! - 0.5 });
    paths.set(label, `${paths.get(label) ?? ''}M${Math.min(a.x, b.x)} ${Math.min(a.y, b.y)}h${Math.abs(b.x - a.x)}v${Math.abs(b.y - a.y)}h${-Math.abs(b.x - a.x)}z`);
  }
  return [...paths].map(([label, path]) => ({ label, colour: `rgb(${labelColours[label] ?? labelColours.white})`, path }));
}
