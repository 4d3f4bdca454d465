// SPDX-License-Identifier: Apache-2.0
// A pixel's colour in the terms of the settings' colour classes.
import type { Rgb } from './exposure';

export interface Tone {
  /** Angle of (U-128, V-128) from +U towards +V, degrees; null for grey, which has none. */
  hue: number | null;
  /** Length of (U-128, V-128) over Y, percent. */
  saturation: number;
  luma: number;
}

/** BT.601 full range, as the service converts. */
export function toneOf([r, g, b]: Rgb): Tone {
  const luma = 0.299 * r + 0.587 * g + 0.114 * b;
  const u = (b - luma) * 0.564;
  const v = (r - luma) * 0.713;
  const length = Math.hypot(u, v);
  return {
    hue: length < 2 ? null : ((Math.atan2(v, u) * 180) / Math.PI + 360) % 360,
    saturation: (100 * length) / Math.max(luma, 1),
    luma,
  };
}
