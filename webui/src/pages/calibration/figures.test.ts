// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { errorCells, figures, lineRows, niceTop, shareBelow } from './figures';

const at = (x_mm: number, y_mm: number, on_floor_mm: number | null) => ({ x_mm, y_mm, on_floor_mm, at_150_mm: 9 });
const line = (name: string, rms_px: number | null, patches = 10, expected = 10) => ({ name, rms_px, patches, expected, worst_px: 1, rms_mm: 1 });

describe('the error map', () => {
  it('is made of cells that touch, from dark to light', () => {
    const { cells, top } = errorCells([at(0, 0, 0.1), at(500, 0, 0.9), at(0, 400, 2), at(500, 400, null)], 'on_floor_mm');
    expect(top).toBe(2);
    expect(cells).toEqual([
      { x: -250, y: -200, width: 500, height: 400, mm: 0.1, bin: 0 },
      { x: 250, y: -200, width: 500, height: 400, mm: 0.9, bin: 2 },
      { x: -250, y: 200, width: 500, height: 400, mm: 2, bin: 5 },
    ]);
    expect(shareBelow(cells, 1)).toBeCloseTo(2 / 3);
    expect(errorCells([], 'at_150_mm').cells).toEqual([]);
    expect(errorCells([at(0, 0, 1)], 'on_floor_mm').cells).toEqual([]);
  });

  it('ends its scale at a round number', () => {
    expect([0.11, 0.2, 3, 5.1, 12, 0, NaN].map(niceTop)).toEqual([0.2, 0.2, 5, 10, 20, 1, 1]);
  });
});

describe('lines', () => {
  it('that are off far more than the others are doubted', () => {
    const rows = lineRows([line('a', 0.2), line('b', 0.22), line('c', 0.8), line('d', 0.2, 3)], (name) => name);
    expect(rows.map(({ doubt }) => doubt)).toEqual(['', '', 'painted elsewhere?', 'only 3 of 10 pieces found']);
    expect(rows.map(({ share }) => share)).toEqual([0.25, expect.closeTo(0.275), 1, 0.25]);
  });

  it('that all lie within a tenth of a pixel are not', () => {
    expect(lineRows([line('a', 0.005), line('b', 0.005), line('c', 0.09), line('d', null)], (name) => name).map(({ doubt }) => doubt)).toEqual(['', '', '', '']);
  });
});

describe('figures', () => {
  it('have about three digits', () => {
    expect([0.0149, 0.131, 1.634, 12.34, 133.7, -2.5].map(figures)).toEqual(['0.015', '0.13', '1.63', '12.3', '134', '−2.50']);
    expect([figures(null), figures(undefined), figures(NaN)]).toEqual([null, null, null]);
  });
});
