// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { ColorMargin, ColorState } from '../../api/types';
import { floorTexts, kindOf, marginRows, marginText, thinnest } from './margins';

const judged = { wanted_margin: 0.3, least_margin: 0.1 };
const margin = (label: string, surface: 'carpet' | 'floor', brighter: number | null, darker: number | null): ColorMargin => ({ label, surface, brighter, darker });
const stateOf = (margins: ColorMargin[] | null) => ({ ...judged, margins }) as ColorState;

describe('margins', () => {
  it('are told in words', () => {
    expect(marginText('carpet', 'green', 0.092)).toBe('carpet becomes green at +9 %');
    expect(marginText('floor', 'orange', -0.3)).toBe('floor becomes orange at −30 %');
    expect(marginText('carpet', 'green', 0.001)).toBe('carpet is green now');
    expect(marginText('carpet', 'pink', null)).toBe('carpet never becomes pink');
  });
  it('are judged as the verdict judges them', () => {
    expect([0, 0.099, -0.1, 0.299, -0.3, 1.2, null].map((change) => kindOf(change, judged))).toEqual(['bad', 'bad', 'warn', 'warn', 'ok', 'ok', 'ok']);
  });
  const both = [
    margin('pink', 'carpet', null, null), margin('cyan', 'carpet', null, null), margin('blue', 'carpet', 0.31, 0.8), margin('green', 'carpet', 0.5, 0.09),
    margin('pink', 'floor', 0.05, null), margin('cyan', 'floor', null, null), margin('blue', 'floor', null, null), margin('green', 'floor', 0.7, 0.001),
  ];
  it('are one row of the carpet for each label, the nearest either way, the least first', () => {
    expect(marginRows(both, judged).map(({ label, change, kind }) => ({ label, change, kind }))).toEqual([
      { label: 'green', change: -0.09, kind: 'bad' },
      { label: 'blue', change: 0.31, kind: 'ok' },
      { label: 'pink', change: null, kind: 'ok' },
      { label: 'cyan', change: null, kind: 'ok' },
    ]);
  });
  it('name the floor beside the carpet, but do not judge it', () => {
    expect(floorTexts(both, judged)).toEqual(['floor is green now', 'floor becomes pink at +5 %']);
    expect(thinnest(stateOf(both.filter(({ surface }) => surface === 'floor')))).toBeNull();
  });
  it('name the thinnest only when it is too thin', () => {
    expect(thinnest(null)).toBeNull();
    expect(thinnest(stateOf(null))).toBeNull();
    expect(thinnest(stateOf([]))).toBeNull();
    expect(thinnest(stateOf([margin('green', 'carpet', 0.3, null)]))).toBeNull();
    expect(thinnest(stateOf([margin('green', 'carpet', 0.2, 0.25), margin('blue', 'carpet', null, 0.15)]))?.label).toBe('blue');
  });
});
