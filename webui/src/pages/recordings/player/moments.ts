// SPDX-License-Identifier: Apache-2.0
// Detections and tracks at one moment, in the form that the field drawings need.
import type { ClipFrame, FieldSize, FieldTracks, LogMoment, RecordedRobot, Robot } from '../../../api/types';
import { NO_ID } from '../../../picture/marks';
import type { OfCamera } from '../../field/live/raw';

/** Division B, until the service or the log gives another field. */
export const defaultField: FieldSize = {
  field_length: 9000, field_width: 6000, goal_width: 1000, goal_depth: 180, boundary_width: 300,
  penalty_area_depth: 1000, penalty_area_width: 2000, center_circle_radius: 500, line_thickness: 10,
  goal_center_to_penalty_mark: 6000, ball_radius: 21.5, max_robot_radius: 90,
};

/** Values missing in a packet are drawn as unknown: "?" for a number, and no heading. */
export const knownRobot = (robot: RecordedRobot): Robot => ({ ...robot, id: robot.id ?? NO_ID, orientation: robot.orientation ?? NaN });

/** `at` in ms relative to the moment; negative if seen before it. */
export function camerasAt(frames: readonly ClipFrame[], time_s: number): OfCamera[] {
  return frames.map(({ camera, number, time_s: seen_s, robots, balls }) => ({ camera, at: (seen_s - time_s) * 1000, detections: { camera, frame: number, t_capture: seen_s, robots: robots.map(knownRobot), balls } }));
}

export function camerasOfLog({ time_s, cameras }: LogMoment): OfCamera[] {
  return cameras.map((one) => ({
    camera: one.id, at: (one.time_s - time_s) * 1000,
    detections: { camera: one.id, frame: 0, t_capture: one.time_s, robots: one.robots.map(knownRobot), balls: one.balls },
  }));
}

export function tracksOfLog({ time_s, tracked }: LogMoment): FieldTracks | null {
  if (!tracked) return null;
  const { robots, ball } = tracked;
  return {
    number: 1, time: time_s, kick: null,
    robots: robots.map((robot) => ({ ...robot, turn_rad_s: 0, sigma_mm: 0, visibility: 1 })),
    balls: ball ? [{ ...ball, vz: 0, visibility: 1 }] : [],
  };
}

/** The log's field; the service's values replace missing ones. */
export function fieldOfLog(moment: LogMoment | null, known: FieldSize): FieldSize {
  if (!moment?.field) return known;
  const { length, width } = moment.field;
  if (length === known.field_length && width === known.field_width) return known;
  // The painted lines of another field would be misplaced.
  return { ...known, field_length: length, field_width: width, goal_center_to_penalty_mark: Math.min(known.goal_center_to_penalty_mark, length), field_lines: null, field_arcs: null };
}
