// SPDX-License-Identifier: Apache-2.0
// The distance between two cameras' positions of the same robot. Their images are not simultaneous, so one camera's
// position is compared with the other's, interpolated between two of its images.
import type { Detections, Robot } from '../../api/types';
import type { CameraModel } from '../../geometry/cameraModel';

/** A camera's two newest detections. */
export type Pictures = { older: Detections | null; newer: Detections };

/** Positions are not interpolated between images farther apart than this, s. */
const LONGEST_GAP_S = 0.2;

export interface Meeting {
  camera: number;
  /** Distance with the calibration in use, mm. */
  inUse: number;
  /** ... and with the proposed one. */
  proposed: number | null;
}

/** The robots of one image that another camera also sees, at the time of that image. */
export function meetings(mine: Detections, theirs: Pictures, proposal: CameraModel | null): Meeting[] {
  const { older, newer } = theirs;
  if (!older || newer.t_capture - older.t_capture > LONGEST_GAP_S) return [];
  const share = (mine.t_capture - older.t_capture) / (newer.t_capture - older.t_capture);
  if (!(share >= 0 && share <= 1)) return [];
  return mine.robots.flatMap((robot) => {
    const same = (one: Robot) => one.team === robot.team && one.id === robot.id;
    const [from, to] = [older.robots.find(same), newer.robots.find(same)];
    if (!from || !to) return [];
    const there = { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) };
    const moved = proposal?.unproject(robot.pixel_x, robot.pixel_y, robot.height);
    return [{
      camera: newer.camera,
      inUse: Math.hypot(robot.x - there.x, robot.y - there.y),
      proposed: moved ? Math.hypot(moved.x - there.x, moved.y - there.y) : null,
    }];
  });
}

export const median = (values: number[]): number | null => {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length ? sorted[Math.floor((sorted.length - 1) / 2)]! : null;
};
