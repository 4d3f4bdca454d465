// SPDX-License-Identifier: Apache-2.0
// The contents of a detection packet, prepared for display.
import type { HeardDetection, Listeners, SentPackets } from '../../api/types';
import { decimal, plural } from '../../format';

export interface SeenRow {
  key: string;
  /** "Ball", "Yellow 4" */
  what: string;
  team: 'yellow' | 'blue' | null;
  x: string;
  y: string;
  angle: string;
  height: string;
  pixel: string;
  confidence: string;
}

const NONE = '–';
/** 0.1 mm is finer than any camera resolves. */
const mm = (value: number | undefined) => (value === undefined ? NONE : decimal(value, 1));
export const degrees = (rad: number | undefined) => (rad === undefined ? NONE : decimal((rad * 180) / Math.PI, 1));
const pixel = (x: number, y: number) => `${decimal(x, 1)}, ${decimal(y, 1)}`;

/** Balls first, then robots, each in the packet's order. */
export function seenRows({ balls, robots_yellow, robots_blue }: HeardDetection['packet']['detection']): SeenRow[] {
  const rows: SeenRow[] = (balls ?? []).map((ball, i) => ({
    key: `ball ${i}`, what: 'Ball', team: null, x: mm(ball.x), y: mm(ball.y), angle: NONE, height: mm(ball.z),
    pixel: pixel(ball.pixel_x, ball.pixel_y), confidence: decimal(ball.confidence, 2),
  }));
  for (const [team, name, robots] of [['yellow', 'Yellow', robots_yellow], ['blue', 'Blue', robots_blue]] as const) {
    (robots ?? []).forEach((robot, i) => rows.push({
      key: `${team} ${i}`, what: `${name} ${robot.robot_id ?? '?'}`, team, x: mm(robot.x), y: mm(robot.y), angle: degrees(robot.orientation),
      height: mm(robot.height), pixel: pixel(robot.pixel_x, robot.pixel_y), confidence: decimal(robot.confidence, 2),
    }));
  }
  return rows;
}

/** Time from exposure to sending in ms, from the packet's own times. */
export const latencyOf = ({ t_capture, t_sent }: HeardDetection['packet']['detection']) => (t_sent - t_capture) * 1000;

/** "2 sockets of user robocup, 1 socket of user root" */
export function programsText(programs: Listeners['programs']): string {
  const users = [...new Set(programs.map(({ user }) => user))];
  return users.map((user) => `${plural(programs.filter((one) => one.user === user).length, 'socket')} of user ${user}`).join(', ');
}

/** "vision of 10.0.0.2 by multicast, game controller of 10.0.0.9 by broadcast" */
export function arrivalsText(arrivals: SentPackets['arrivals']): string {
  return arrivals.map(({ what, address, multicast, broadcast }) => `${what} of ${address} by ${[multicast && 'multicast', broadcast && 'broadcast'].filter(Boolean).join(' and ')}`).join(', ');
}
