// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { ColorMargin, ColorState } from '../../api/types';
import { kindOf, marginRows, marginText, thinnest } from './margins';

const judged = { wanted_margin: 0.3, least_margin: 0.1 };
const margin = (label: string, surface: 'carpet' | 'floor', brighter: number | null, darker: number | null): ColorMargin => ({ label, surface, brighter, darker });
const stateOf = (margins: ColorMargin[] | null) => ({ ...judged, margins }) as ColorState;

describe('margins', () => {
  it('are told in words', () => {
    expect(marginText('carpet', 'green', 0.092)).toBe('carpet becomes green at +9 %');
    expect(marginText('floor', 'orange', -0.3)).toBe('floor becomes orange at −30 %');
    expect(marginText('carpet', 'green', 0.001)).toBe('carpet is green now');
    expect(marginText('carpet', 'pink', null)).toBe('carpet and floor never become pink');
  });
  it('are judged as the verdict judges them', () => {
    expect([0, 0.099, -0.1, 0.299, -0.3, 1.2, null].map((change) => kindOf(change, judged))).toEqual(['bad', 'bad', 'warn', 'warn', 'ok', 'ok', 'ok']);
  });
  it('are one row for each label, of the nearest surface either way, the least first', () => {
    const rows = marginRows([
      margin('pink', 'carpet', null, null), margin('green', 'carpet', 0.5, null), margin('blue', 'carpet', 0.31, 0.8),
      margin('pink', 'floor', null, null), margin('green', 'floor', 0.7, 0.09), margin('blue', 'floor', null, null),
    ], judged);
    expect(rows.map(({ label, surface, change, kind }) => ({ label, surface, change, kind }))).toEqual([
      { label: 'green', surface: 'floor', change: -0.09, kind: 'bad' },
      { label: 'blue', surface: 'carpet', change: 0.31, kind: 'ok' },
      { label: 'pink', surface: 'carpet', change: null, kind: 'ok' },
    ]);
  });
  it('name the thinnest only when it is too thin', () => {
    expect(thinnest(null)).toBeNull();
    expect(thinnest(stateOf(null))).toBeNull();
    expect(thinnest(stateOf([]))).toBeNull();
    expect(thinnest(stateOf([margin('green', 'carpet', 0.3, null)]))).toBeNull();
    expect(thinnest(stateOf([margin('green', 'carpet', 0.2, 0.25), margin('blue', 'carpet', null, 0.15)]))?.label).toBe('blue');
  });
});
