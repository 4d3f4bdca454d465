// SPDX-License-Identifier: Apache-2.0
// Merges the reports of several cameras into one field.
import type { Ball, Robot } from '../api/types';

export type SeenRobot = Robot & { camera: number };
export type SeenBall = Ball & { camera: number };

/** Reports closer than this are the same object; farther apart, both are drawn: one of them is wrong. */
const SAME_ROBOT_MM = 300;
const SAME_BALL_MM = 150;

function merge<T extends { x: number; y: number; confidence: number; camera: number }>(
  seen: T[],
  same: (a: T, b: T) => boolean,
): T[] {
  // The camera number breaks ties, so that the drawing does not flicker.
  const best = [...seen].sort((a, b) => b.confidence - a.confidence || a.camera - b.camera);
  const kept: T[] = [];
  for (const object of best) if (!kept.some((other) => same(other, object))) kept.push(object);
  return kept;
}

const near = (a: { x: number; y: number }, b: { x: number; y: number }, mm: number) =>
  Math.hypot(a.x - b.x, a.y - b.y) < mm;

export function mergeRobots(seen: SeenRobot[]): SeenRobot[] {
  return merge(seen, (a, b) => a.team === b.team && a.id === b.id && near(a, b, SAME_ROBOT_MM))
    .sort((a, b) => (a.team === b.team ? a.id - b.id : a.team < b.team ? 1 : -1));
}

/** Two balls of one camera are never merged, however close they are. */
export function mergeBalls(seen: SeenBall[]): SeenBall[] {
  return merge(seen, (a, b) => a.camera !== b.camera && near(a, b, SAME_BALL_MM));
}
