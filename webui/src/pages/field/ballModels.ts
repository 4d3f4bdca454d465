// SPDX-License-Identifier: Apache-2.0
// What the published ball models predict for a kick.

export interface BallModels {
  acc_slide: number;
  acc_roll: number;
  k_switch: number;
  damping_xy_first_hop: number;
  damping_xy_other_hops: number;
  damping_z: number;
}

export interface Roll {
  /** Distance in m until the ball rolls, and until it stops; null: never. */
  slide_m: number | null;
  stop_m: number | null;
  /** m/s when it starts to roll. */
  switch_m_s: number;
}

/** Distance over which the speed drops from one value to another, m; null: it never does. */
const way = (from: number, to: number, acc: number) => (from <= to ? 0 : acc < 0 ? (from * from - to * to) / (-2 * acc) : null);

export function rollOf(models: BallModels, kick_m_s: number): Roll {
  const switch_m_s = kick_m_s * models.k_switch;
  const slide_m = way(kick_m_s, switch_m_s, models.acc_slide);
  const roll_m = way(switch_m_s, 0, models.acc_roll);
  return { switch_m_s, slide_m, stop_m: slide_m === null || roll_m === null ? null : slide_m + roll_m };
}

/** Speed in m/s after a distance in m. */
export function speedAfter(models: BallModels, kick_m_s: number, distance_m: number): number {
  const { slide_m, switch_m_s } = rollOf(models, kick_m_s);
  const isSliding = slide_m === null || distance_m < slide_m;
  const square = isSliding ? kick_m_s ** 2 + 2 * models.acc_slide * distance_m : switch_m_s ** 2 + 2 * models.acc_roll * (distance_m - slide_m);
  return Math.sqrt(Math.max(0, square));
}

/** Heights in mm of the hops that follow a hop of height_mm. */
export const hops = ({ damping_z }: BallModels, height_mm: number, count: number): number[] =>
  Array.from({ length: count }, (_, i) => height_mm * damping_z ** (2 * (i + 1)));
