// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { camera, divisionB } from '../../../testing/samples';
import { coverageMap, isInside, sharesOf } from './coverage';

it('a place is inside or outside', () => {
  const square = [{ x: 0, y: 0 }, { x: 2, y: 0 }, { x: 2, y: 2 }, { x: 0, y: 2 }];
  expect(isInside({ x: 1, y: 1 }, square)).toBe(true);
  expect(isInside({ x: 3, y: 1 }, square)).toBe(false);
  expect(isInside({ x: 1, y: -1 }, square)).toBe(false);
  expect(isInside({ x: 1, y: 1 }, [])).toBe(false);
});

it('every place has its number of cameras; the service knows the holes', () => {
  const cameras = [camera(), camera({ id: 1 }), camera({ id: 2, calibration: null })];
  const map = coverageMap(divisionB, cameras, { grid_mm: 250, uncovered: [[1125, 125], [-4375, 2875]] });
  expect(map.outlines.map((outline) => outline.camera)).toEqual([0, 1]);
  expect(map.squares).toHaveLength(36 * 24);
  const at = (x: number, y: number) => map.squares.find((square) => square.x === x && square.y === y)?.count;
  expect(at(1375, 125)).toBe(2);
  expect(at(1125, 125)).toBe(0);
  const shares = sharesOf(map);
  expect(shares.map(({ count }) => count)).toEqual([0, 2]);
  expect(shares.reduce((sum, { percent }) => sum + percent, 0)).toBeCloseTo(100);
});
