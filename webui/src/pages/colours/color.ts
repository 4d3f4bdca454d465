// SPDX-License-Identifier: Apache-2.0
import type { Rgb } from '../../picture/exposure';
import type { Triple } from './table';

const clamp = (value: number) => Math.min(255, Math.max(0, Math.round(value)));

/** BT.601 full range, as daemon/image/color.h. */
export function rgbOfYuv([y, u, v]: Triple): Rgb {
  return [clamp(y + 1.402 * (v - 128)), clamp(y - 0.344136 * (u - 128) - 0.714136 * (v - 128)), clamp(y + 1.772 * (u - 128))];
}
export const cssOfYuv = (yuv: Triple) => `rgb(${rgbOfYuv(yuv)})`;
