// SPDX-License-Identifier: Apache-2.0
// Extrapolates tracked objects and predicts the ball's path. mm, mm/s, radians, seconds.
import type { FieldKick, FieldSize, TrackedBall, TrackedRobot } from '../../../api/types';
import type { Point } from '../../../geometry/cameraModel';
import type { BallModels } from '../ballModels';

/** Objects are extrapolated this far beyond the last message; then they stay where they are. */
export const CARRY_S = 0.25;
/** Below this visibility, the service has not seen an object for some images. */
const SEEN = 0.9;
const GRAVITY_MM_S2 = 9810;
/** A ball whose centre is this far above its height on the floor is in the air. */
export const FLYING_MM = 50;

export const isSeen = ({ visibility }: { visibility: number }): boolean => visibility >= SEEN;
export const speedOf = ({ vx, vy }: { vx: number; vy: number }): number => Math.hypot(vx, vy);

/** How far to extrapolate objects of this age. */
export const carryOf = (age_s: number): number => Math.min(CARRY_S, Math.max(0, age_s));

export interface Pose { x: number; y: number; orientation: number }
export const carriedRobot = (robot: TrackedRobot, dt_s: number): Pose => ({
  x: robot.x + dt_s * robot.vx, y: robot.y + dt_s * robot.vy, orientation: robot.orientation + dt_s * robot.turn_rad_s,
});

export function carriedBall(ball: TrackedBall, dt_s: number, radius_mm: number): { x: number; y: number; z: number } {
  const isFlying = ball.z > radius_mm + FLYING_MM || ball.vz !== 0;
  const z = isFlying ? ball.z + dt_s * ball.vz - (GRAVITY_MM_S2 / 2) * dt_s ** 2 : ball.z;
  return { x: ball.x + dt_s * ball.vx, y: ball.y + dt_s * ball.vy, z: Math.max(Math.min(radius_mm, ball.z), z) };
}

export interface BallPath {
  /** Where a flying ball lands; null: it is on the floor. */
  landing: Point | null;
  /** Where it stops, or leaves the drawing. */
  end: Point;
  /** It stops before the edge. */
  stops: boolean;
}

/** Distance over which the speed drops from one value to another; Infinity without braking. */
const way = (from: number, to: number, acc: number) => (from <= to ? 0 : acc < 0 ? (from ** 2 - to ** 2) / (-2 * acc) : Infinity);

/** Lower speeds are tracker noise. */
const STILL_MM_S = 60;
/** For this long after a kick, its speed determines whether the ball still slides. */
const SLIDES_S = 3;

/**
 * Predicted path of the ball without contacts. It slides until its speed is k_switch times the kick's, then it rolls;
 * without a matching kick it only rolls. `time`: Unix time of the ball. Null: it is at rest.
 */
export function ballPath(ball: TrackedBall, kick: FieldKick | null, time: number, models: BallModels, field: FieldSize): BallPath | null {
  const speed = speedOf(ball);
  if (speed < STILL_MM_S) return null;
  const direction = { x: ball.vx / speed, y: ball.vy / speed };
  let from: Point = ball;
  let rest = speed;
  let landing: Point | null = null;
  const height = ball.z - field.ball_radius;
  if (height > FLYING_MM) {
    const fall_s = (ball.vz + Math.sqrt(ball.vz ** 2 + 2 * GRAVITY_MM_S2 * height)) / GRAVITY_MM_S2;
    landing = from = { x: ball.x + fall_s * ball.vx, y: ball.y + fall_s * ball.vy };
    // The speed lost in later hops is small compared with the first hop's loss.
    rest *= models.damping_xy_first_hop;
  }
  const isOwn = kick !== null && !kick.is_chip && landing === null && time >= kick.time && time - kick.time < SLIDES_S;
  const rolls_at = isOwn ? models.k_switch * 1000 * kick.speed_m_s : rest;
  const length_mm = way(rest, rolls_at, 1000 * models.acc_slide) + way(Math.min(rest, rolls_at), 0, 1000 * models.acc_roll);
  const edge_mm = toEdge(from, direction, field);
  const reach = Math.min(length_mm, edge_mm);
  return { landing, end: { x: from.x + reach * direction.x, y: from.y + reach * direction.y }, stops: length_mm <= edge_mm };
}

/** Distance from a point to the edge of the drawing; 0 from outside. */
function toEdge(from: Point, direction: Point, field: FieldSize): number {
  const one = (at: number, step: number, half: number) => (step > 0 ? (half - at) / step : step < 0 ? (-half - at) / step : Infinity);
  return Math.max(0, Math.min(
    one(from.x, direction.x, field.field_length / 2 + field.boundary_width),
    one(from.y, direction.y, field.field_width / 2 + field.boundary_width),
  ));
}
