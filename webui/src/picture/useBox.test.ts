// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { isEnlarged } from './useBox';

describe('isEnlarged', () => {
  it('compares with what the screen shows', () => {
    expect(isEnlarged(780, 780, 1, 1)).toBe(false);
    expect(isEnlarged(780, 780, 1.1, 1)).toBe(true);
    expect(isEnlarged(780, 780, 0.5, 1)).toBe(false);
    expect(isEnlarged(780, 780, 0.6, 2)).toBe(true);
  });

  it('knows that a Bayer camera has half as many cells as pixels', () => {
    expect(isEnlarged(1224, 2448, 0.5, 1)).toBe(false);
    expect(isEnlarged(1224, 2448, 0.6, 1)).toBe(true);
  });
});
