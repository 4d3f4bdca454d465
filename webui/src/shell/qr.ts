// SPDX-License-Identifier: Apache-2.0
// An address as a QR code, for a phone's camera.
import { encode } from 'uqr';

/** Light border around it, modules (ISO/IEC 18004). */
const QUIET = 4;

export interface QrPath { side: number; path: string }

/** The dark modules as an SVG path, and the side of the whole square. */
export function qrPath(text: string): QrPath {
  const { data, size } = encode(text, { ecc: 'M', border: QUIET });
  let path = '';
  data.forEach((row, y) => {
    row.forEach((isDark, x) => { if (isDark) path += `M${x} ${y}h1v1h-1z`; });
  });
  return { side: size, path };
}
