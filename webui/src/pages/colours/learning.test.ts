// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import type { LearningPicture, LearningReport } from '../../api/types';
import { found, sourceText } from './learning';

const picture = (before: number, after: number): LearningPicture => {
  const detections = (count: number) => ({ robots: Array.from({ length: count }), balls: [{}] }) as unknown as LearningPicture['before'];
  return { frame: 1, t_capture: 0, width: 10, height: 10, before: detections(before), after: detections(after), taught: [] };
};

it('adds up what is found in all images', () => {
  expect(found([picture(3, 12), picture(4, 12)], 'before')).toEqual({ robots: 7, balls: 2 });
  expect(found([picture(3, 12), picture(4, 12)], 'after')).toEqual({ robots: 24, balls: 2 });
});

it('says what it learnt from', () => {
  const report = { robots: { yellow: 6, blue: 5 }, balls: 1, pictures: [picture(0, 1), picture(0, 1)] } as unknown as LearningReport;
  expect(sourceText(report)).toBe('11 robots (6 yellow, 5 blue) and 1 ball in 2 images');
});
