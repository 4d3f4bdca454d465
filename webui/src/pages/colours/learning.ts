// SPDX-License-Identifier: Apache-2.0
// What learning would change, in numbers.
import type { LearningPicture, LearningReport } from '../../api/types';

export interface Found {
  robots: number;
  balls: number;
}

/** Number of detections in the given images. */
export function found(pictures: readonly LearningPicture[], when: 'before' | 'after'): Found {
  return pictures.reduce((sum, picture) => ({ robots: sum.robots + picture[when].robots.length, balls: sum.balls + picture[when].balls.length }), { robots: 0, balls: 0 });
}

/** "12 robots (6 yellow, 6 blue) and 3 balls in 3 images" */
export function sourceText({ robots, balls, pictures }: LearningReport): string {
  const all = robots.yellow + robots.blue;
  const count = (value: number, word: string) => `${value} ${word}${value === 1 ? '' : 's'}`;
  return `${count(all, 'robot')} (${robots.yellow} yellow, ${robots.blue} blue) and ${count(balls, 'ball')} in ${count(pictures.length, 'image')}`;
}
