// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Clip, LastSeconds } from '../api/types';
import { clipFacts, clipNowText, clipTitle, droppedOf, goBackSeconds, imagesText, lastSecondsText, memoryText } from './words';

const last = (...seconds: number[]): LastSeconds => ({
  memory_bytes: 256e6, wanted_bytes: 512e6, images: 'whole', every_nth: 4, problem: '',
  cameras: seconds.map((one, id) => ({ id, seconds: one, frames: 75 * one, bytes: 128e6, dropped: id })),
});

describe('the last seconds in words', () => {
  it('say how far back the cameras reach', () => {
    expect(lastSecondsText(last(6.2, 6.2))).toBe('The last 6.2 s of 2 cameras are in memory');
    expect(lastSecondsText(last(20.4, 12.2))).toBe('The last 12 to 20 s of 2 cameras are in memory');
    expect(lastSecondsText(last())).toBe('Nothing is in memory yet');
    expect(lastSecondsText(last(0))).toBe('Nothing is in memory yet');
  });
  it('say what of the images is kept, and the memory', () => {
    expect(imagesText(last())).toBe('Whole images');
    expect(imagesText({ ...last(), images: 'every_nth', every_nth: 2 })).toBe('Every 2nd image');
    expect(imagesText({ ...last(), images: 'every_nth', every_nth: 11 })).toBe('Every 11th image');
    expect(memoryText(last())).toBe('256 MB; 512 MB needed for all');
    expect(memoryText({ ...last(), wanted_bytes: 256e6 })).toBe('256 MB');
    expect(droppedOf(last(1, 1, 1))).toBe(3);
  });
  it('say how far one can go back', () => {
    expect(goBackSeconds(last(30, 6.7), 20)).toBe(20);
    expect(goBackSeconds(last(30, 6.7), 20, 1)).toBe(6);
    expect(goBackSeconds(last(0.4), 20)).toBe(0);
    expect(goBackSeconds(last(5), 20, 9)).toBe(0);
  });
});

describe('a clip in words', () => {
  const clip = (changes: Partial<Clip> = {}): Clip => ({
    name: '2026-11-26_22-40_look_back.clip', bytes: 412e6, begin_s: null, seconds: 9.94, why: 'kept by hand',
    cameras: [{ id: 0, frames: 742, missing: 0 }, { id: 1, frames: 740, missing: 2 }], pinned: false, problem: '', ...changes,
  });
  it('has a title, a length and what is missing', () => {
    expect(clipFacts(clip())).toMatchObject({ title: 'Look back', when: '2026-11-26 22:40', length: '9.9 s', cameras: '2 cameras', missing: '2 missing', size: '412 MB', isReading: true });
    expect(clipFacts(clip({ begin_s: 1, cameras: [{ id: 3, frames: 1, missing: 0 }] }))).toMatchObject({ cameras: 'camera 3', missing: '', isReading: false });
    expect(clipTitle('2026-11-26_22-40.clip')).toBe('Clip');
  });
  it('tells how its writing goes', () => {
    const now = { state: 'writing' as const, name: clip().name, why: '', frames: 1200, missing: 0, bytes: 5e6, error: '' };
    expect(clipNowText(now)).toBe('Keeping Look back: 1\u2009200 images, 5.0 MB so far');
    expect(clipNowText({ ...now, state: 'failed', error: 'the disk is full' })).toBe('The clip could not be kept: the disk is full');
    expect(clipNowText({ ...now, state: 'idle' })).toBe('');
  });
});
