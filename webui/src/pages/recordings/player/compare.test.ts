// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Comparison, ComparisonResult, Difference } from '../../../api/types';
import { marks } from '../../../picture/marks';
import { robot } from '../../../testing/samples';
import { differenceText, isOf, resultText, ringsOf } from './compare';

const result = (changes: Partial<ComparisonResult> = {}): ComparisonResult => ({
  exact: true, why_not_exact: '', frames: 742, frames_that_differ: 31, frames_with_other_bytes: 31, found: 3, lost: 40, moved: 12, id_changed: 0, largest_mm: 4.08, threshold_mm: 1, differences: [], ...changes,
});
const difference = (changes: Partial<Difference> = {}): Difference => ({ place: 4, time_s: 0.1, kind: 'lost', what: 'yellow 3', by_mm: 0, by_deg: 0, x_mm: 0, y_mm: 0, pixel_x: 99, pixel_y: 49, ...changes });

describe('a comparison in words', () => {
  it('says what differs', () => {
    expect(resultText(result())).toBe('31 of 742 frames differ: 3 found, 40 lost, 12 moved by up to 4.1 mm.');
    expect(resultText(result({ found: 0, moved: 0, id_changed: 2 }))).toBe('31 of 742 frames differ: 40 lost, 2 with a changed number.');
  });
  it('says that nothing does', () => {
    expect(resultText(result({ frames_that_differ: 0 }))).toBe('Nothing differs in 742 frames.');
    expect(resultText(result({ frames: 1, frames_that_differ: 0 }))).toBe('Nothing differs in 1 frame.');
  });
  it('names each difference', () => {
    expect(differenceText(difference())).toBe('yellow 3 lost');
    expect(differenceText(difference({ kind: 'moved', what: 'ball', by_mm: 2.13 }))).toBe('ball moved 2.1 mm');
    expect(differenceText(difference({ kind: 'moved', by_mm: 0, by_deg: 1.4 }))).toBe('yellow 3 turned 1.4°');
    expect(differenceText(difference({ kind: 'id' }))).toBe('yellow 3 with a changed number');
  });
});

it('knows whose comparison it is', () => {
  const one: Comparison = { state: 'done', clip: 'a.clip', camera: 1, with: 'settings_now', done: 1, frames: 1, error: '', result: null };
  expect(isOf(one, 'a.clip', 1)).toBe(true);
  expect(isOf(one, 'b.clip', 1)).toBe(false);
  expect(isOf({ ...one, state: 'idle' }, 'a.clip', 1)).toBe(false);
  expect(isOf(null, 'a.clip', 1)).toBe(false);
});

it('draws rings where something differs, also in a turned image', () => {
  const size = { width: 200, height: 100 };
  const drawn = (turn: 0 | 1) => marks({ camera: 0, frame: 1, t_capture: 0, picture: 'camera', ...size, robots: [robot({ pixel_x: 10, pixel_y: 10 })], balls: [] }, { robot: 90, ball: 21 }, null, turn);
  const [ring] = ringsOf([difference()], drawn(0), size, 0);
  expect(ring).toMatchObject({ kind: 'lost', x: 99.5, y: 49.5 });
  expect(ring!.radius).toBeGreaterThan(drawn(0).robots[0]!.radius);
  expect(ringsOf([difference()], drawn(1), size, 1)[0]).toMatchObject({ x: 50.5, y: 99.5 });
});
