// SPDX-License-Identifier: Apache-2.0

const DIM = 0.3;

/** A darker version of a palette. */
export function dimmed(colours: Uint32Array): Uint32Array {
  return colours.map((pixel) => {
    const part = (shift: number) => Math.round(((pixel >>> shift) & 255) * DIM) << shift;
    return ((255 << 24) | part(16) | part(8) | part(0)) >>> 0;
  });
}

export const WHITE = 0xffffffff;

/** Draws one pixel per label. If `bright` is given, the marked pixels are white and the others dim. */
export function drawLabels(canvas: HTMLCanvasElement | null, width: number, height: number, labels: Uint8Array, colours: Uint32Array, bright?: Uint8Array | null): void {
  const context = canvas?.getContext('2d', { alpha: false });
  if (!canvas || !context) return;
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  const image = context.createImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  if (bright && bright.length !== labels.length) bright = null;
  const table = bright ? dimmed(colours) : colours;
  for (let i = 0; i < pixels.length; i++) pixels[i] = bright?.[i] ? WHITE : table[labels[i]!]!;
  context.putImageData(image, 0, 0);
}
