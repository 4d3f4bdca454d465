// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { MAX_ZOOM, panned, zoomed } from './view';
import { WHOLE } from './useBox';

const frame = { width: 800, height: 600 };
const picture = { width: 1600, height: 1200 };

describe('zoom and pan', () => {
  it('keeps the point under the pointer', () => {
    expect(zoomed(WHOLE, 2, 100, 50, frame, picture)).toEqual({ zoom: 2, x: -100, y: -50 });
  });
  it('has limits', () => {
    expect(zoomed(WHOLE, 0.5, 0, 0, frame, picture)).toEqual(WHOLE);
    expect(zoomed(WHOLE, 1e6, 0, 0, frame, picture).zoom).toBe(MAX_ZOOM);
    expect(panned({ zoom: 2, x: 0, y: 0 }, 9999, -9999, frame, picture)).toEqual({ zoom: 2, x: 400, y: -300 });
    expect(panned(WHOLE, 50, 50, frame, picture)).toEqual(WHOLE);
  });
});
