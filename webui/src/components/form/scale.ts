// SPDX-License-Identifier: Apache-2.0
// Maps values to positions on a slider, 0 to 1.

export interface Scale {
  shareOf(value: number): number;
  valueAt(share: number): number;
}

const clamp = (share: number) => Math.min(1, Math.max(0, share));

export function linearScale(min: number, max: number): Scale {
  return {
    shareOf: (value) => clamp((value - min) / (max - min)),
    valueAt: (share) => min + clamp(share) * (max - min),
  };
}

/**
 * Positions of a logarithmic slider; values are rounded to three significant figures, which can still be set by
 * dragging.
 */
export const LOG_POSITIONS = 1000;

/** Logarithmic scale: equal distances are equal factors. min > 0. */
export function logScale(min: number, max: number, whole: boolean): Scale {
  const decades = Math.log(max / min);
  return {
    shareOf: (value) => clamp(Math.log(Math.max(value, min) / min) / decades),
    valueAt: (share) => {
      const value = Number((min * Math.exp(clamp(share) * decades)).toPrecision(3));
      return Math.min(max, Math.max(min, whole ? Math.round(value) : value));
    },
  };
}
