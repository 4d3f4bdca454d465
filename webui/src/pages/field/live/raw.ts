// SPDX-License-Identifier: Apache-2.0
// Reports of single cameras side by side, and the distance between two cameras' positions.
import type { Detections, FieldTracks, Robot, Team } from '../../../api/types';

/** Ages at which a camera's objects are old, and are removed. */
export const OLD_MS = 250;
const GONE_MS = 1000;
/** Images farther apart in time are not compared. */
const SAME_S = 0.1;
/** Two cameras' reports of one robot that are farther apart belong to two robots. */
const SAME_MM = 500;
/** Time constant for smoothing a difference: nobody reads thirty numbers a second. */
const SETTLE_S = 0.5;
const FORGET_S = 0.25;

export interface Apart {
  team: Team;
  id: number;
  /** The last position of the robot. */
  x: number;
  y: number;
  /** The second camera's position relative to the first camera's. */
  dx: number;
  dy: number;
  time: number;
}

export interface OfCamera { camera: number; detections: Detections; at: number }

type Speeds = Pick<FieldTracks, 'robots'> | null;

export class RawReports {
  private readonly cameras = new Map<number, OfCamera>();
  private readonly apart = new Map<string, Apart>();

  /** Sorted by camera. `now`: as from performance.now(). */
  of(now: number): OfCamera[] {
    for (const [camera, { at }] of this.cameras) if (now - at > GONE_MS) this.cameras.delete(camera);
    return [...this.cameras.values()].sort((a, b) => a.camera - b.camera);
  }

  /** One per robot and pair of cameras. */
  differences(time: number): Apart[] {
    for (const [key, one] of this.apart) if (Math.abs(time - one.time) > FORGET_S) this.apart.delete(key);
    return [...this.apart.values()];
  }

  /** Adds one image's objects. Tracked velocities give each robot's motion between the two cameras' images. */
  take(detections: Detections, at: number, tracks: Speeds): void {
    for (const other of this.cameras.values()) {
      if (other.camera !== detections.camera && Math.abs(other.detections.t_capture - detections.t_capture) <= SAME_S) this.compare(other.detections, detections, tracks);
    }
    this.cameras.set(detections.camera, { camera: detections.camera, detections, at });
  }

  clear(): void {
    this.cameras.clear();
    this.apart.clear();
  }

  private compare(one: Detections, two: Detections, tracks: Speeds): void {
    const [first, second] = one.camera < two.camera ? [one, two] : [two, one];
    const dt_s = second.t_capture - first.t_capture;
    for (const a of first.robots) {
      const b = second.robots.find((robot) => isSame(a, robot));
      if (!b) continue;
      const track = tracks?.robots.find(({ team, id }) => team === a.team && id === a.id);
      const dx = b.x - a.x - dt_s * (track?.vx ?? 0);
      const dy = b.y - a.y - dt_s * (track?.vy ?? 0);
      const key = `${a.team} ${a.id} ${first.camera} ${second.camera}`;
      const before = this.apart.get(key);
      const time = two.t_capture;
      const part = before && time > before.time ? 1 - Math.exp(-(time - before.time) / SETTLE_S) : before ? 0 : 1;
      this.apart.set(key, {
        team: a.team, id: a.id, x: two === first ? a.x : b.x, y: two === first ? a.y : b.y, dx: (before?.dx ?? 0) + part * (dx - (before?.dx ?? 0)),
        dy: (before?.dy ?? 0) + part * (dy - (before?.dy ?? 0)), time: Math.max(time, before?.time ?? 0),
      });
    }
  }
}

const isSame = (a: Robot, b: Robot) => a.team === b.team && a.id === b.id && Math.hypot(a.x - b.x, a.y - b.y) < SAME_MM;

/** CSS variables of cameras' colours; further cameras reuse them and are distinguished by their numbers. */
const COLOURS = ['--g1', '--g2', '--g4', '--g3', '--g5', '--g7', '--g8', '--g6'] as const;
export const colourOfCamera = (camera: number): (typeof COLOURS)[number] => COLOURS[camera % COLOURS.length]!;
