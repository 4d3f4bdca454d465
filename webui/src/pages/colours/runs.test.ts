// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { decodeLabelPicture } from './runs';

it('reads a labelled image', () => {
  const { width, height, labels } = decodeLabelPicture(Uint8Array.from([3, 0, 2, 0, 5, 2, 0, 3, 7, 1]).buffer);
  expect([width, height]).toEqual([3, 2]);
  expect([...labels]).toEqual([5, 5, 0, 0, 0, 7]);
  // 300 pixels of one label: the length takes two bytes.
  expect(decodeLabelPicture(Uint8Array.from([0x2c, 1, 1, 0, 4, 0xac, 2]).buffer).labels.every((label) => label === 4)).toBe(true);
});

it('refuses one that is cut short', () => {
  expect(() => decodeLabelPicture(Uint8Array.from([3, 0]).buffer)).toThrow('cut short');
  expect(() => decodeLabelPicture(Uint8Array.from([3, 0, 2, 0, 5, 2]).buffer)).toThrow('2 labels instead of 6');
});
