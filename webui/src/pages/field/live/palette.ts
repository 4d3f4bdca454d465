// SPDX-License-Identifier: Apache-2.0
// The theme's colours and sizes for a canvas.

const NAMES = [
  '--fld', '--fld-edge', '--fld-line', '--t1', '--t2', '--s-1', '--warn', '--ball', '--t-yellow',
  '--g1', '--g2', '--g3', '--g4', '--g5', '--g6', '--g7', '--g8', '--q2', '--q3', '--q4', '--q5',
] as const;
export type ColourName = (typeof NAMES)[number];

export interface Palette {
  colours: Record<ColourName, string>;
  /** Smallest type size of the design, CSS pixels. */
  type_px: number;
  font: string;
}

/** Blue is darker on robots than in lines, so that a white number is readable; as everywhere in the panel. */
export const BODY = { yellow: '#ffd21f', blue: '#2c62ea' } as const;
export const BODY_INK = { yellow: '#1c1500', blue: '#ffffff' } as const;
/** Lines of a team, which must contrast with dark and pale carpets. */
export const TEAM_LINE = { yellow: '--g4', blue: '--g1' } as const;

export function paletteOf(element: Element): Palette {
  const style = getComputedStyle(element);
  const value = (name: string) => style.getPropertyValue(name).trim();
  return {
    colours: Object.fromEntries(NAMES.map((name) => [name, value(name)])) as Record<ColourName, string>,
    type_px: parseFloat(value('--fs-xs')) || 12,
    font: value('--font'),
  };
}

export const fontOf = ({ type_px, font }: Palette, times = 1): string => `700 ${type_px * times}px ${font}`;
