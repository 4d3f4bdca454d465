// SPDX-License-Identifier: Apache-2.0
import jsQR from 'jsqr';
import { describe, expect, it } from 'vitest';
import { qrPath } from './qr';

/** Decodes it as a phone does. */
function read({ side, path }: ReturnType<typeof qrPath>): string | null {
  const scale = 4;
  const width = side * scale;
  const pixels = new Uint8ClampedArray(width * width * 4).fill(255);
  for (const [, x, y] of path.matchAll(/M(\d+) (\d+)h1v1h-1z/g)) {
    for (let dy = 0; dy < scale; dy++) {
      for (let dx = 0; dx < scale; dx++) {
        const at = 4 * ((Number(y) * scale + dy) * width + Number(x) * scale + dx);
        pixels.fill(0, at, at + 3);
      }
    }
  }
  return jsQR(pixels, width, width)?.data ?? null;
}

describe('the QR code', () => {
  it('leads where it should', () => {
    for (const address of ['http://192.168.1.10:8090/', 'http://[2001:db8::1]:8090/', 'http://field-pc.local:65535/'])
      expect(read(qrPath(address))).toBe(address);
  });
  it('has room around it', () => {
    const { side, path } = qrPath('http://10.0.0.1:8090/');
    const places = [...path.matchAll(/M(\d+) (\d+)/g)].flatMap(([, x, y]) => [Number(x), Number(y)]);
    expect(Math.min(...places)).toBe(4);
    expect(Math.max(...places)).toBe(side - 5);
  });
});
