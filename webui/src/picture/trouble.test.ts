// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { pictureTrouble } from './trouble';

const fine = { state: 'running' as const, error: '', silentSeconds: null, age: 0.1, isLinkSlow: false, gapAtService: 0.5 };

describe('why an image is not live', () => {
  it('says nothing of a live one', () => expect(pictureTrouble(fine)).toBeNull());
  it('says how old a lost camera\'s image is and why', () => {
    expect(pictureTrouble({ ...fine, state: 'lost', error: 'no answer from 10.0.0.7', age: 12.4 }))
      .toMatchObject({ title: 'Camera lost', notes: ['Last image 12 s old', 'no answer from 10.0.0.7'], bad: true });
  });
  it('blames the connection before the camera', () => {
    expect(pictureTrouble({ ...fine, state: 'lost', silentSeconds: 4, age: 4 })).toMatchObject({ title: 'No data for 4 s', bad: false });
  });
  it('sees that the camera sends nothing', () => {
    for (const isLinkSlow of [false, true])
      expect(pictureTrouble({ ...fine, age: 5, gapAtService: 4, isLinkSlow })).toMatchObject({ title: 'No image for 5 s', bad: true });
  });
  it('blames the link for images that the service has', () => {
    expect(pictureTrouble({ ...fine, age: 5 })).toEqual({ icon: 'link', title: 'Slow link', notes: ['image 5 s old'], bad: false, isMark: true });
    expect(pictureTrouble({ ...fine, age: 2, isLinkSlow: true })?.title).toBe('Slow link');
    expect(pictureTrouble({ ...fine, age: null, isLinkSlow: true })?.title).toBe('Slow link');
    expect(pictureTrouble({ ...fine, age: 1, isLinkSlow: true })).toBeNull();
  });
  it('says that a camera is lost on a slow link, too', () => {
    expect(pictureTrouble({ ...fine, state: 'lost', age: 5, isLinkSlow: true })).toMatchObject({ title: 'Camera lost', bad: true });
  });
  it('waits for the first', () => expect(pictureTrouble({ ...fine, age: null })?.title).toBe('Waiting for an image'));
});
