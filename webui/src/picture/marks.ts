// SPDX-License-Identifier: Apache-2.0
// Positions of an image's robots, balls and tags, in pixels of the (turned) image.
import type { Ball, PreviewHeader, Robot } from '../api/types';
import type { CameraModel, Point, Point3 } from '../geometry/cameraModel';
import { turnPixel, turnedSize, type Size, type Turn } from '../geometry/turn';

export interface RobotMark {
  key: string;
  robot: Robot;
  centre: Point;
  /** Approximate radius of the ring. */
  radius: number;
  ring: string;
  heading: string;
  /** Unit direction of the heading in the image. */
  ahead: Point;
}

export interface BallMark {
  key: string;
  ball: Ball;
  centre: Point;
  radius: number;
}

/** A thing that resembles a robot. */
export interface MissMark {
  centre: Point;
  radius: number;
  text: string;
}

export interface Marks {
  size: Size;
  robots: RobotMark[];
  balls: BallMark[];
  misses: MissMark[];
}

/** Radius of a ring without a calibration, as a share of the image's width. */
const BLIND_RADIUS = 0.02;
/** A ball's ring is wider than the ball, so that it does not hide the ball. */
const BALL_RING = 2.2;

const round = (value: number) => Math.round(value * 10) / 10;
const at = (p: Point) => `${round(p.x)} ${round(p.y)}`;

/** Image vectors of a radius along the field's x and along its y. */
function axes({ x, y, z }: Point3, radius: number, model: CameraModel | null, picture: Size, turn: Turn): [Point, Point] {
  const centre = model?.project(x, y, z);
  const alongX = model?.project(x + radius, y, z);
  const alongY = model?.project(x, y + radius, z);
  if (!centre || !alongX || !alongY) {
    const blind = BLIND_RADIUS * picture.width;
    return [{ x: blind, y: 0 }, { x: 0, y: -blind }];
  }
  const c = turnPixel(turn, picture, centre);
  const [u, v] = [turnPixel(turn, picture, alongX), turnPixel(turn, picture, alongY)];
  return [{ x: u.x - c.x, y: u.y - c.y }, { x: v.x - c.x, y: v.y - c.y }];
}

function robotMark(robot: Robot, key: string, radius: number, model: CameraModel | null, picture: Size, turn: Turn): RobotMark {
  const centre = turnPixel(turn, picture, { x: robot.pixel_x, y: robot.pixel_y });
  const [ux, uy] = axes({ x: robot.x, y: robot.y, z: robot.height }, radius, model, picture, turn);
  const point = (angle: number, reach: number): Point => ({
    x: centre.x + reach * (Math.cos(angle) * ux.x + Math.sin(angle) * uy.x),
    y: centre.y + reach * (Math.cos(angle) * ux.y + Math.sin(angle) * uy.y),
  });
  const corners = 36;
  const ring = Array.from({ length: corners }, (_, i) => at(point((i / corners) * 2 * Math.PI, 1)));
  /** A recorded packet may have no heading. */
  const hasNoHeading = Number.isNaN(robot.orientation);
  const front = point(robot.orientation, 1);
  const tip = point(robot.orientation, 2);
  const length = Math.hypot(front.x - centre.x, front.y - centre.y) || 1;
  return {
    key, robot, centre,
    radius: Math.max(Math.hypot(ux.x, ux.y), Math.hypot(uy.x, uy.y)),
    ring: `M${ring.join('L')}Z`,
    // The direction of the field's x is unknown in an uncalibrated image, and so is the heading.
    heading: model && !hasNoHeading ? `M${at(front)}L${at(tip)}` : '',
    ahead: !model || hasNoHeading ? { x: 0, y: 0 } : { x: (front.x - centre.x) / length, y: (front.y - centre.y) / length },
  };
}

export interface Radii {
  robot: number;
  ball: number;
}

export function marks(header: PreviewHeader, radii: Radii, model: CameraModel | null, turn: Turn): Marks {
  const picture = { width: header.width, height: header.height };
  const count = new Map<string, number>();
  const robots = header.robots.map((robot) => {
    const name = `${robot.team}${robot.id}`;
    const seen = count.get(name) ?? 0;
    count.set(name, seen + 1);
    return robotMark(robot, seen ? `${name}/${seen}` : name, radii.robot, model, picture, turn);
  });
  const balls = header.balls.map((ball, i) => {
    const [ux] = axes({ x: ball.x, y: ball.y, z: radii.ball }, radii.ball, model, picture, turn);
    const radius = model ? Math.hypot(ux.x, ux.y) : Math.sqrt(ball.area / Math.PI);
    return { key: String(i), ball, centre: turnPixel(turn, picture, { x: ball.pixel_x, y: ball.pixel_y }), radius: radius * BALL_RING };
  });
  const misses = (header.misses ?? []).map(({ pixel_x, pixel_y, radius, text }) =>
    ({ centre: turnPixel(turn, picture, { x: pixel_x, y: pixel_y }), radius, text }));
  return { size: turnedSize(turn, picture), robots, balls, misses };
}

/** For a recorded packet without the robot's number. */
export const NO_ID = -1;
export const idText = (id: number): string => (id === NO_ID ? '?' : String(id));
export const tagText = (robot: Robot) => `${robot.team === 'yellow' ? 'y' : 'b'}${idText(robot.id)}`;

export interface Tag {
  key: string;
  robot: Robot;
  centre: Point;
  /** Offset from the robot's centre, screen pixels. */
  offset: Point;
}

const SIDES: readonly Point[] = [{ x: 0, y: -1 }, { x: 0, y: 1 }, { x: 1, y: 0 }, { x: -1, y: 0 }];
const TAG = { width: 22, height: 15, gap: 5 };

/**
 * Places each tag on the side of its robot that is clear of its heading, of other robots, balls and tags, and inside
 * the image. A tag changes its side only if another one is clearly better, so that it does not jump; `sides` stores the
 * sides.
 */
export function placeTags({ size, robots, balls }: Marks, scale: number, sides: Map<string, number>): Tag[] {
  const things = [...robots, ...balls].map(({ centre, radius }) => ({ x: centre.x * scale, y: centre.y * scale, reach: radius * scale }));
  const placed: Point[] = [];
  const tags = robots.map(({ key, robot, centre, radius, ahead }, self) => {
    const ring = radius * scale;
    const from = { x: centre.x * scale, y: centre.y * scale };
    const offsets = SIDES.map((side) => ({
      x: side.x * (ring + TAG.gap + TAG.width / 2),
      y: side.y * (ring + TAG.gap + TAG.height / 2),
    }));
    const cost = offsets.map((offset, i) => {
      const x = from.x + offset.x;
      const y = from.y + offset.y;
      let sum = i * 0.1 - (sides.get(key) === i ? 0.6 : 0);
      sum += 1.5 * Math.max(0, ahead.x * SIDES[i]!.x + ahead.y * SIDES[i]!.y);
      const overX = Math.max(0, TAG.width / 2 - x, x + TAG.width / 2 - size.width * scale);
      const overY = Math.max(0, TAG.height / 2 - y, y + TAG.height / 2 - size.height * scale);
      if (overX + overY > 0) sum += 4;
      things.forEach((thing, j) => {
        if (j !== self && Math.abs(thing.x - x) < TAG.width / 2 + thing.reach && Math.abs(thing.y - y) < TAG.height / 2 + thing.reach) sum += 2;
      });
      for (const tag of placed) if (Math.abs(tag.x - x) < TAG.width && Math.abs(tag.y - y) < TAG.height) sum += 3;
      return sum;
    });
    const best = cost.indexOf(Math.min(...cost));
    sides.set(key, best);
    const offset = offsets[best]!;
    placed.push({ x: from.x + offset.x, y: from.y + offset.y });
    return { key, robot, centre, offset };
  });
  for (const key of sides.keys()) if (!robots.some((mark) => mark.key === key)) sides.delete(key);
  return tags;
}
