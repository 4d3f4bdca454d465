// SPDX-License-Identifier: Apache-2.0
// Robots that a camera saw in one frame and not in the next.
import type { ClipEvent, ClipFrame } from '../../../api/types';

type Seen = Pick<ClipFrame, 'time_s' | 'camera' | 'robots'>;
/** Robots without a number cannot be distinguished. */
const keysOf = ({ robots }: Seen) => new Set(robots.filter(({ id }) => id !== null).map(({ team, id }) => `${team} ${id}`));

/** "Camera 0 loses yellow 3" */
export function lostBetween(before: Seen, after: Seen): ClipEvent[] {
  const still = keysOf(after);
  return [...keysOf(before)].filter((key) => !still.has(key))
    .map((key) => ({ time_s: after.time_s, kind: 'lost', text: `Camera ${after.camera} loses ${key}` }));
}

/** Collects frames in any order and finds the robots that were lost. */
export class LostRobots {
  private readonly known = new Map<number, Seen>();
  private readonly pairs = new Map<number, ClipEvent[]>();

  /** `index`: among the camera's frames. Returns whether there are new events. */
  take(index: number, frame: Seen): boolean {
    if (this.known.has(index)) return false;
    this.known.set(index, { time_s: frame.time_s, camera: frame.camera, robots: frame.robots });
    let isNews = false;
    for (const first of [index - 1, index]) {
      const [before, after] = [this.known.get(first), this.known.get(first + 1)];
      if (!before || !after) continue;
      const events = lostBetween(before, after);
      if (events.length) isNews = true;
      this.pairs.set(first, events);
    }
    return isNews;
  }
  knows(index: number): boolean { return this.known.has(index); }
  get count(): number { return this.known.size; }
  get events(): ClipEvent[] { return [...this.pairs.values()].flat().sort((a, b) => a.time_s - b.time_s); }
}
