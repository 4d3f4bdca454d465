// SPDX-License-Identifier: Apache-2.0
// The pixels of a frozen image whose colours are in cells where two labels touch. Raw pixels are fetched once, on
// demand.
import { computed, onUnmounted, shallowRef, watch } from 'vue';
import { api } from '../../api/client';
import type { Pixels, Still } from '../../api/types';
import { bytesOf } from './pixels';
import { cellIndex, cellOf, type Table } from './table';

/** Edge of a fetched tile in cells: answers for larger areas contain no colours. */
const TILE = 128;

interface Raw {
  still: number;
  width: number;
  height: number;
  cellPx: number;
  yuv: Uint8Array;
}

export function useMeeting(camera: number, still: () => Still | null, conflicts: () => Uint8Array | null, table: () => Table | null) {
  const raw = shallowRef<Raw | null>(null);
  let alive = true;
  onUnmounted(() => { alive = false; });

  async function fetchAll(of: Still): Promise<void> {
    const tile = (x: number, y: number, side: number) => api.get<Pixels>(`cameras/${camera}/pixels?x=${x}&y=${y}&width=${side}&height=${side}&still=${of.still}`);
    const { cell_px: cellPx } = await tile(0, 0, 2);
    const [width, height] = [Math.floor(of.width / cellPx), Math.floor(of.height / cellPx)];
    const yuv = new Uint8Array(3 * width * height);
    for (let top = 0; top < height; top += TILE) {
      for (let left = 0; left < width; left += TILE) {
        const part = await tile(left * cellPx, top * cellPx, TILE * cellPx);
        if (!alive || still()?.still !== of.still || part.yuv === null) return;
        const bytes = bytesOf(part.yuv);
        for (let row = 0; row < part.rows && top + row < height; row++) {
          const columns = Math.min(part.columns, width - left);
          yuv.set(bytes.subarray(3 * row * part.columns, 3 * (row * part.columns + columns)), 3 * ((top + row) * width + left));
        }
      }
    }
    raw.value = { still: of.still, width, height, cellPx, yuv };
  }

  watch(() => (conflicts() ? still() : null), (of) => {
    if (of && raw.value?.still !== of.still) void fetchAll(of).catch(() => { /* The slices still show them. */ });
  });

  /** 1 for each such cell of the image; null: unknown. */
  const bright = computed(() => {
    const [mask, of, pixels] = [conflicts(), table(), raw.value];
    if (!mask || !of || !pixels || pixels.still !== still()?.still) return null;
    const { yuv } = pixels;
    return Uint8Array.from({ length: pixels.width * pixels.height }, (_, i) =>
      mask[cellIndex(of, cellOf(of, yuv[3 * i]!), cellOf(of, yuv[3 * i + 1]!), cellOf(of, yuv[3 * i + 2]!))]!);
  });
  return {
    bright,
    pixels: computed(() => (bright.value && raw.value ? bright.value.reduce((sum, one) => sum + one, 0) * raw.value.cellPx ** 2 : null)),
  };
}
