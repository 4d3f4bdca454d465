// SPDX-License-Identifier: Apache-2.0
// Draws the tracks of all cameras together: robots, the ball, where they are going and where they were.
import type { FieldKick, FieldSize, FieldTracks, Team, TrackedBall, TrackedRobot } from '../../../api/types';
import { idText } from '../../../picture/marks';
import type { BallModels } from '../ballModels';
import { ballPath, carriedBall, carriedRobot, isSeen, speedOf, type Pose } from './motion';
import { BODY, BODY_INK, TEAM_LINE } from './palette';
import { arrow, ballRadius, circle, FRONT, label, lineTo, moveTo, robotBody, robotRadius, setType, type Pen } from './pen';
import { angleOn, leftOf, topOf } from './place';
import { TRAIL_S, type Trail, type TrailKind } from './trails';
import { heightText } from './words';

export interface Scene {
  field: FieldSize;
  tracks: FieldTracks;
  /** How far objects are extrapolated from the tracks. */
  dt_s: number;
  /** The tracks are late: everything is drawn as unseen. */
  isLate: boolean;
  /** Unix time on the service's clock. */
  time: number;
  trails: Iterable<Trail> | null;
  /** The newest first. */
  kicks: readonly FieldKick[];
  /** null: not published, so the ball's path is unknown. */
  models: BallModels | null;
}

/** An arrow is as long as the robot's path in this time. */
export const ARROW_S = 0.4;
const SLOWEST_MM_S = 80;
const FAINT = 0.5;
const DASH = [4, 3];

const TEAMS: readonly Team[] = ['yellow', 'blue'];

/** Draws trails and kicks, which change so slowly that not every frame needs them redrawn. */
export function drawPast(pen: Pen, scene: Scene): void {
  drawKicks(pen, scene);
  if (scene.trails) drawTrails(pen, scene.trails, scene.time);
}

/** Draws the current state and the prediction. */
export function drawTracks(pen: Pen, scene: Scene): void {
  const { tracks } = scene;
  const [ball] = tracks.balls;
  if (ball) drawPath(pen, scene, ball);
  for (const team of TEAMS) drawRobots(pen, scene, team);
  for (const other of tracks.balls.slice(1)) drawBall(pen, scene, other, 0.7);
  if (ball) drawBall(pen, scene, ball, 1);
  pen.ctx.globalAlpha = 1;
}

// ---- robots

function drawRobots(pen: Pen, { field, tracks, dt_s, isLate }: Scene, team: Team): void {
  const { ctx, view, palette: { colours } } = pen;
  const r = robotRadius(pen, field);
  const line = colours[TEAM_LINE[team]];
  const all = tracks.robots.filter((robot) => robot.team === team).map((robot) => ({ robot, pose: carriedRobot(robot, dt_s), seen: !isLate && isSeen(robot) }));
  const seen = all.filter((one) => one.seen);
  const unseen = all.filter((one) => !one.seen);

  ctx.strokeStyle = line;
  ctx.lineWidth = 2;
  ctx.globalAlpha = 1;
  ctx.beginPath();
  for (const { robot, pose } of seen) traceSpeed(pen, robot, pose, r);
  ctx.stroke();

  ctx.beginPath();
  for (const { pose } of seen) robotBody(pen, pose.x, pose.y, pose.orientation, r);
  ctx.fillStyle = BODY[team];
  ctx.fill();
  ctx.strokeStyle = '#0007';
  ctx.lineWidth = 1;
  ctx.stroke();
  ctx.beginPath();
  for (const { pose } of seen) traceFront(pen, pose, r - 1);
  ctx.strokeStyle = colours['--t1'];
  ctx.lineWidth = 2;
  ctx.stroke();

  if (unseen.length) {
    ctx.beginPath();
    for (const { pose } of unseen) robotBody(pen, pose.x, pose.y, pose.orientation, r);
    ctx.globalAlpha = 0.16;
    ctx.fillStyle = BODY[team];
    ctx.fill();
    ctx.globalAlpha = 0.85;
    ctx.strokeStyle = line;
    ctx.lineWidth = 1.5;
    ctx.setLineDash(DASH);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
  }

  setType(pen);
  for (const { robot, pose, seen: isBright } of all) {
    const left = leftOf(view, pose.x, pose.y);
    const top = topOf(view, pose.x, pose.y) + 0.5;
    ctx.fillStyle = isBright ? BODY_INK[team] : colours['--t1'];
    ctx.fillText(idText(robot.id), left, top);
  }
}

function traceFront({ ctx, view }: Pen, { x, y, orientation }: Pose, r: number): void {
  const [left, top, angle] = [leftOf(view, x, y), topOf(view, x, y), angleOn(view, orientation)];
  ctx.moveTo(left + r * Math.cos(angle + FRONT), top + r * Math.sin(angle + FRONT));
  ctx.lineTo(left + r * Math.cos(angle - FRONT), top + r * Math.sin(angle - FRONT));
}

function traceSpeed(pen: Pen, robot: TrackedRobot, { x, y }: Pose, r: number): void {
  const speed = speedOf(robot);
  if (speed < SLOWEST_MM_S) return;
  const { view } = pen;
  const [left, top] = [leftOf(view, x, y), topOf(view, x, y)];
  const length = ARROW_S * speed * view.scale;
  const angle = angleOn(view, Math.atan2(robot.vy, robot.vx));
  const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
  arrow(pen, left + r * dx, top + r * dy, left + (r + length) * dx, top + (r + length) * dy, Math.min(5, 1 + length / 2));
}

// ---- trails

const FADES = 4;
const KINDS: readonly TrailKind[] = ['yellow', 'blue', 'ball'];

/** Few strokes for many trails: pieces of similar age and colour are drawn together. */
function drawTrails(pen: Pen, trails: Iterable<Trail>, time: number): void {
  const { ctx, palette: { colours } } = pen;
  const all = [...trails];
  ctx.lineWidth = 2;
  ctx.lineJoin = 'round';
  for (const kind of KINDS) {
    ctx.strokeStyle = kind === 'ball' ? colours['--ball'] : colours[TEAM_LINE[kind]];
    const ours = all.filter((trail) => trail.kind === kind);
    for (let fade = 0; fade < FADES; fade++) {
      ctx.beginPath();
      for (const { points } of ours) {
        let isOn = false;
        for (let i = 1; i < points.length; i++) {
          const [a, b] = [points[i - 1]!, points[i]!];
          const band = Math.floor((FADES * (time - b.t)) / TRAIL_S);
          if (b.isStart || Math.min(FADES - 1, Math.max(0, band)) !== fade || band >= FADES) { isOn = false; continue; }
          if (!isOn) moveTo(pen, a.x, a.y);
          lineTo(pen, b.x, b.y);
          isOn = true;
        }
      }
      ctx.globalAlpha = 0.5 * (1 - fade / FADES);
      ctx.stroke();
    }
  }
  ctx.globalAlpha = 1;
}

// ---- the ball

function drawPath(pen: Pen, { field, tracks, dt_s, models, time }: Scene, ball: TrackedBall): void {
  if (!models) return;
  const now = { ...ball, ...carriedBall(ball, dt_s, field.ball_radius) };
  const path = ballPath(now, tracks.kick, time, models, field);
  if (!path) return;
  const { ctx, palette: { colours } } = pen;
  ctx.strokeStyle = colours['--ball'];
  ctx.lineWidth = 2;
  ctx.lineCap = 'round';
  ctx.setLineDash([0.1, 5]);
  ctx.beginPath();
  moveTo(pen, now.x, now.y);
  lineTo(pen, path.end.x, path.end.y);
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.lineCap = 'butt';
  ctx.beginPath();
  if (path.landing) cross(pen, path.landing.x, path.landing.y, 5);
  if (path.stops) circle(pen, path.end.x, path.end.y, ballRadius(pen, field));
  ctx.lineWidth = 1.5;
  ctx.stroke();
}

/** Increase of the ring's radius per metre of the ball's height, pixels. */
const RING_PX = 22;
const SHADOW_PX = 26;

function drawBall(pen: Pen, { field, dt_s, isLate }: Scene, ball: TrackedBall, size: number): void {
  const { ctx, view, palette: { colours } } = pen;
  const { x, y, z } = carriedBall(ball, dt_s, field.ball_radius);
  const r = size * ballRadius(pen, field);
  const [left, top] = [leftOf(view, x, y), topOf(view, x, y)];
  const seen = !isLate && isSeen(ball);
  const height = heightText(z);
  const lift = Math.min(2, z / 1000);
  ctx.globalAlpha = seen ? 1 : FAINT;
  if (height) {
    // The light comes from the upper left, so the shadow moves to the lower right.
    ctx.fillStyle = '#0006';
    ctx.beginPath();
    ctx.ellipse(left + 4 + SHADOW_PX * lift, top + 4 + SHADOW_PX * lift, r, 0.8 * r, 0, 0, 2 * Math.PI);
    ctx.fill();
  }
  ctx.beginPath();
  ctx.arc(left, top, r, 0, 2 * Math.PI);
  if (seen) {
    ctx.fillStyle = colours['--ball'];
    ctx.fill();
  }
  ctx.strokeStyle = seen ? '#0009' : colours['--ball'];
  ctx.lineWidth = seen ? 1 : 1.5;
  if (!seen) ctx.setLineDash([2.5, 2]);
  ctx.stroke();
  if (height) {
    const ring = r + 3 + RING_PX * lift;
    ctx.beginPath();
    ctx.arc(left, top, ring, 0, 2 * Math.PI);
    ctx.strokeStyle = colours['--ball'];
    ctx.lineWidth = 2;
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
    setType(pen);
    label(pen, height, left, top + (top < ring + 24 ? ring + 10 : -ring - 10), colours['--t1']);
  }
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

// ---- kicks

const KICKS = 5;
const KICK_S = 20;
/** Length of a kick's line for each m/s. */
const KICK_MM = 130;

function cross(pen: Pen, x: number, y: number, r: number): void {
  const { ctx, view } = pen;
  const [left, top] = [leftOf(view, x, y), topOf(view, x, y)];
  ctx.moveTo(left - r, top - r);
  ctx.lineTo(left + r, top + r);
  ctx.moveTo(left + r, top - r);
  ctx.lineTo(left - r, top + r);
}

function drawKicks(pen: Pen, { kicks, time }: Scene): void {
  const { ctx, view, palette: { colours } } = pen;
  ctx.strokeStyle = ctx.fillStyle = colours['--t1'];
  ctx.lineWidth = 1.5;
  for (const kick of kicks.slice(0, KICKS)) {
    const age_s = time - kick.time;
    if (age_s > KICK_S) break;
    ctx.globalAlpha = 0.75 * (1 - Math.max(0, age_s) / KICK_S);
    const [left, top] = [leftOf(view, kick.x, kick.y), topOf(view, kick.x, kick.y)];
    ctx.beginPath();
    ctx.moveTo(left, top - 4);
    ctx.lineTo(left + 4, top);
    ctx.lineTo(left, top + 4);
    ctx.lineTo(left - 4, top);
    ctx.fill();
    ctx.beginPath();
    const [landingX, landingY] = kick.landing ?? [];
    if (landingX !== undefined && landingY !== undefined) {
      ctx.setLineDash(DASH);
      ctx.moveTo(left, top);
      lineTo(pen, landingX, landingY);
      ctx.stroke();
      ctx.setLineDash([]);
      ctx.beginPath();
      cross(pen, landingX, landingY, 5);
    } else {
      const angle = angleOn(view, Math.atan2(kick.vy, kick.vx));
      const length = KICK_MM * kick.speed_m_s * view.scale;
      arrow(pen, left, top, left + length * Math.cos(angle), top + length * Math.sin(angle));
    }
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}
