// SPDX-License-Identifier: Apache-2.0
// Finds the over- and under-exposed pixels of an image.

/** Over-exposed: any channel from this value. Noise and JPEG keep a clipped channel from always being 255. */
export const OVER_FROM = 250;
/** Under-exposed: all channels up to this value. */
export const UNDER_TO = 6;

export type Rgb = readonly [number, number, number];

export interface ExposureMarks {
  over?: Rgb;
  under?: Rgb;
}

export interface ExposureShare {
  /** Share of the image's pixels, 0 to 1. */
  over: number;
  under: number;
}

/** Stripes of two opacities distinguish the marks from objects of that colour; every marked pixel is painted. */
const STRIPE_PX = 4;
const STRONG = 255;
const WEAK = 150;

/**
 * Paints the marks of an image (both RGBA; transparent where there is no mark). A kind without a colour is only
 * counted.
 */
export function markExposure(picture: Uint8ClampedArray, width: number, marks: Uint8ClampedArray, { over, under }: ExposureMarks): ExposureShare {
  const count = { over: 0, under: 0 };
  const pixels = picture.length / 4;
  for (let i = 0, x = 0, y = 0; i < pixels; i++) {
    const at = i * 4;
    const r = picture[at]!;
    const g = picture[at + 1]!;
    const b = picture[at + 2]!;
    let colour: Rgb | undefined;
    if (r >= OVER_FROM || g >= OVER_FROM || b >= OVER_FROM) {
      count.over++;
      colour = over;
    } else if (r <= UNDER_TO && g <= UNDER_TO && b <= UNDER_TO) {
      count.under++;
      colour = under;
    }
    if (colour) {
      marks[at] = colour[0];
      marks[at + 1] = colour[1];
      marks[at + 2] = colour[2];
      marks[at + 3] = (x + y) % (2 * STRIPE_PX) < STRIPE_PX ? STRONG : WEAK;
    } else {
      marks[at + 3] = 0;
    }
    if (++x === width) {
      x = 0;
      y++;
    }
  }
  return { over: count.over / pixels, under: count.under / pixels };
}
