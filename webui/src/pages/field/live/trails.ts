// SPDX-License-Identifier: Apache-2.0
// Positions of objects in the last two seconds.
import type { FieldTracks } from '../../../api/types';

export const TRAIL_S = 2;
/** Points closer than this in time do not make a line smoother: every second one of thirty a second is kept. */
const STEP_S = 0.06;
/** Points farther apart are not joined: the object was lost, or another object has its name now. */
const GAP_S = 0.4;
const GAP_MM = 700;

export type TrailKind = 'yellow' | 'blue' | 'ball';
interface TrailPoint { t: number; x: number; y: number; isStart: boolean }
export interface Trail { kind: TrailKind; points: TrailPoint[] }

export class Trails {
  private readonly trails = new Map<string, Trail>();
  private last = 0;

  get all(): Iterable<Trail> { return this.trails.values(); }

  /** Adds tracks. An earlier time than before means that the service was restarted. */
  add({ time, robots, balls }: FieldTracks): void {
    if (time < this.last) this.trails.clear();
    this.last = time;
    for (const { team, id, x, y } of robots) this.extend(`${team} ${id}`, team, time, x, y);
    if (balls[0]) this.extend('ball', 'ball', time, balls[0].x, balls[0].y);
    for (const [key, { points }] of this.trails) {
      while (points[0] && points[0].t < time - TRAIL_S) points.shift();
      if (!points.length) this.trails.delete(key);
    }
  }

  clear(): void { this.trails.clear(); }

  private extend(key: string, kind: TrailKind, t: number, x: number, y: number): void {
    let trail = this.trails.get(key);
    if (!trail) this.trails.set(key, trail = { kind, points: [] });
    const last = trail.points.at(-1);
    if (last && t - last.t < STEP_S) return;
    const isStart = !last || t - last.t > GAP_S || Math.hypot(x - last.x, y - last.y) > GAP_MM;
    trail.points.push({ t, x, y, isStart });
  }
}
