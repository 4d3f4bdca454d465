// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { robot } from '../testing/samples';
import { mergeBalls, mergeRobots } from './merge';

const ball = (camera: number, x: number, confidence = 0.9) => ({ camera, x, y: 0, confidence, area: 40, pixel_x: 0, pixel_y: 0 });

describe('merging cameras', () => {
  it('draws a robot of the overlap once, as the surer camera sees it', () => {
    const merged = mergeRobots([
      { ...robot({ id: 3, x: 0, confidence: 0.8 }), camera: 0 },
      { ...robot({ id: 3, x: 12, confidence: 0.9 }), camera: 1 },
      { ...robot({ id: 3, team: 'blue', x: 5 }), camera: 1 },
    ]);
    expect(merged.map((r) => [r.team, r.id, r.camera])).toEqual([['yellow', 3, 1], ['blue', 3, 1]]);
  });

  it('shows an identity that is in two places twice', () => {
    expect(mergeRobots([{ ...robot({ x: -1000 }), camera: 0 }, { ...robot({ x: 1000 }), camera: 1 }])).toHaveLength(2);
  });

  it('merges balls of different cameras only', () => {
    expect(mergeBalls([ball(0, 0), ball(1, 20)])).toHaveLength(1);
    expect(mergeBalls([ball(0, 0), ball(0, 60)])).toHaveLength(2);
    expect(mergeBalls([ball(0, 0), ball(1, 900)])).toHaveLength(2);
  });
});
