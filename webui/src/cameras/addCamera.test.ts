// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { folderName, freeId, isAddress, isImageName } from './addCamera';

describe('a new camera', () => {
  it('has a free id', () => {
    expect(freeId({ cameras: [{ id: 0 }, { id: 2 }] })).toBe(1);
    expect(freeId({})).toBe(0);
  });
  it('is known by an address that can be one', () => {
    expect(isAddress('192.168.10.20')).toBe(true);
    for (const text of ['', '192.168.10', '192.168.10.256', '192.168.10.20.1', 'camera.local']) expect(isAddress(text)).toBe(false);
  });
  it('shows images of the kinds that the service reads', () => {
    for (const name of ['a.jpg', 'A.JPEG', 'b.png']) expect(isImageName(name)).toBe(true);
    for (const name of ['a.gif', 'jpg', 'a.png.zip']) expect(isImageName(name)).toBe(false);
  });
  it('has a folder that is named after the moment', () => {
    expect(folderName(new Date(2026, 10, 5, 4, 3, 2))).toBe('images 2026-11-05 04.03.02');
  });
});
