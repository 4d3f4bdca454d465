// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB } from '../../testing/samples';
import { newName, publishedArcs, publishedLines } from './published';

describe('published lines and arcs', () => {
  it('have the field\'s thickness unless they have their own', () => {
    expect(publishedLines(divisionB)[0]).toEqual({ name: 'TopTouchLine', x1: -4500, y1: 3000, x2: 4500, y2: 3000, thickness: 10 });
    const field_lines = [{ name: 'Tape', x1: 0, y1: 0, x2: 1, y2: 1, thickness: 0 }, { name: 'Paint', x1: 0, y1: 0, x2: 2, y2: 2, thickness: 25 }];
    expect(publishedLines({ ...divisionB, field_lines }).map(({ thickness }) => thickness)).toEqual([10, 25]);
    expect(publishedArcs(divisionB)).toEqual([{ name: 'CenterCircle', x: 0, y: 0, radius: 500, a1: 0, a2: 2 * Math.PI, thickness: 10 }]);
  });
  it('get names of their own', () => {
    expect(newName('Line', ['Line 3', 'x'])).toBe('Line 4');
    expect(newName('Line', ['Line 2'])).toBe('Line 3');
  });
});
