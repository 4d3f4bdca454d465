// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { toneOf } from './pixel';

describe('tone', () => {
  it('has the hue of the colour classes', () => {
    // The ranges of config/demo.json.
    const within = (rgb: [number, number, number], [from, to]: [number, number]) => {
      const { hue } = toneOf(rgb);
      expect(hue).toBeGreaterThan(from);
      expect(hue).toBeLessThan(to);
    };
    within([255, 138, 31], [108, 147]);
    within([255, 212, 0], [148, 185]);
    within([58, 116, 255], [308, 350]);
    within([255, 84, 166], [40, 107]);
    within([120, 230, 60], [190, 230]);
  });

  it('has no hue in a grey', () => {
    expect(toneOf([120, 120, 120])).toMatchObject({ hue: null, luma: expect.closeTo(120) });
  });
});
