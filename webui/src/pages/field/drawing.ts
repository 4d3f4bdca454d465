// SPDX-License-Identifier: Apache-2.0
// The field's plan in screen pixels, so that text and dimension lines keep their size for every field.
import type { FieldSize } from '../../api/types';
import type { Point } from '../../geometry/cameraModel';
import { fieldArcs, fieldLines } from '../../geometry/fieldLines';
import type { Size } from '../../geometry/turn';

export type SizeKey = Exclude<keyof FieldSize, 'field_lines' | 'field_arcs'>;

export interface Dimension {
  key: SizeKey;
  mm: number;
  from: Point;
  to: Point;
  /** From the measured points to the line's ends. */
  extensions: [Point, Point][];
  label: Point;
  anchor: 'start' | 'middle';
}

/** Margins around the plan for the outer dimensions. */
export const MARGIN = { left: 50, right: 58, top: 12, bottom: 40 };
/** From the plan's edge to an outer dimension. */
const OUTSIDE = 20;
/** From a dimension line to its label. */
const BESIDE = 7;

const goalLineBoundary = (field: FieldSize) => field.boundary_width_goal_line ?? field.boundary_width;
/** From the centre to the edge of the drawing, mm. */
const extent = (field: FieldSize): Point => ({
  x: field.field_length / 2 + Math.max(goalLineBoundary(field), field.goal_depth),
  y: field.field_width / 2 + field.boundary_width,
});

export interface Plane {
  /** Pixels per mm. */
  scale: number;
  /** The field's centre, pixels. */
  middle: Point;
}

/** The largest plan that fits with its dimensions; several fields share one scale. */
export function planeFor(fields: FieldSize[], box: Size): Plane {
  const halves = fields.map(extent);
  const half = { x: Math.max(...halves.map(({ x }) => x)), y: Math.max(...halves.map(({ y }) => y)) };
  const room = { x: box.width - MARGIN.left - MARGIN.right, y: box.height - MARGIN.top - MARGIN.bottom };
  return {
    scale: Math.max(0, Math.min(room.x / half.x, room.y / half.y) / 2),
    middle: { x: MARGIN.left + room.x / 2, y: MARGIN.top + room.y / 2 },
  };
}

/** Converts a point of the field (mm, +y up) to the drawing. */
export const place = ({ scale, middle }: Plane, x: number, y: number): Point => ({ x: middle.x + x * scale, y: middle.y - y * scale });

const round = (value: number) => Math.round(value * 100) / 100;
const pathOf = (points: Point[]) => `M${points.map(({ x, y }) => `${round(x)} ${round(y)}`).join('L')}`;

export interface Plan {
  edge: { x: number; y: number; width: number; height: number };
  carpet: { x: number; y: number; width: number; height: number };
  lines: string;
  goals: string;
  marks: Point[];
}

export function planOf(field: FieldSize, plane: Plane): Plan {
  const at = (x: number, y: number) => place(plane, x, y);
  const [a, b, g] = [field.field_length / 2, field.field_width / 2, field.goal_width / 2];
  const rect = (x: number, y: number) => ({ ...at(-x, y), width: 2 * x * plane.scale, height: 2 * y * plane.scale });
  const mark = field.goal_center_to_penalty_mark - a;
  return {
    edge: rect(a + goalLineBoundary(field), b + field.boundary_width),
    carpet: rect(a, b),
    lines: [...fieldLines(field).map(({ p1, p2 }) => [p1, p2]), ...fieldArcs(field)]
      .map((points) => pathOf(points.map(({ x, y }) => at(x, y)))).join(''),
    goals: [1, -1].map((side) => pathOf([at(side * a, g), at(side * (a + field.goal_depth), g), at(side * (a + field.goal_depth), -g), at(side * a, -g)])).join(''),
    marks: [at(mark, 0), at(-mark, 0)],
  };
}

/** Every size that is visible from above, with its dimension line. */
export function dimensionsOf(field: FieldSize, plane: Plane): Dimension[] {
  const at = (x: number, y: number) => place(plane, x, y);
  const [a, b] = [field.field_length / 2, field.field_width / 2];
  const g = field.goal_width / 2;
  const [px, py] = [a - field.penalty_area_depth, field.penalty_area_width / 2];
  const outer = { x: a + goalLineBoundary(field), y: b + field.boundary_width };
  const corner = at(-outer.x, -outer.y);
  const far = at(Math.max(outer.x, a + field.goal_depth), 0).x;
  const middleOf = (p: Point, q: Point): Point => ({ x: (p.x + q.x) / 2, y: (p.y + q.y) / 2 });

  const dimensions: Dimension[] = [];
  /** Adds a dimension between two points of the drawing, its line offset by `aside`. */
  const add = (key: SizeKey, p: Point, q: Point, aside: Point, label?: Point, anchor: Dimension['anchor'] = 'middle') => {
    const from = { x: p.x + aside.x, y: p.y + aside.y };
    const to = { x: q.x + aside.x, y: q.y + aside.y };
    const isAside = aside.x !== 0 || aside.y !== 0;
    dimensions.push({
      key, mm: field[key] ?? 0, from, to, extensions: isAside ? [[p, from], [q, to]] : [],
      label: label ?? middleOf(from, to), anchor,
    });
  };

  add('field_length', at(-a, -b), at(a, -b), { x: 0, y: corner.y + OUTSIDE - at(0, -b).y });
  add('field_width', at(-a, b), at(-a, -b), { x: corner.x - OUTSIDE - at(-a, 0).x, y: 0 });
  const band = at(a * 0.55, -b - field.boundary_width / 2);
  add('boundary_width', at(a * 0.55, -b), at(a * 0.55, -outer.y), { x: 0, y: 0 }, { x: band.x + BESIDE, y: band.y }, 'start');
  const side = at(outer.x, b * 0.72);
  add('boundary_width_goal_line', at(a, b * 0.72), side, { x: 0, y: 0 }, { x: side.x + BESIDE, y: side.y }, 'start');
  add('goal_width', at(a + field.goal_depth, g), at(a + field.goal_depth, -g), { x: far + OUTSIDE - at(a + field.goal_depth, 0).x, y: 0 });
  const deep = at(-a - field.goal_depth, -g);
  add('goal_depth', deep, at(-a, -g), { x: 0, y: 8 }, { x: middleOf(deep, at(-a, -g)).x, y: deep.y + 8 + 11 });
  const top = middleOf(at(-a, py), at(-px, py));
  add('penalty_area_depth', at(-a, py), at(-px, py), { x: 0, y: -12 }, { x: top.x, y: top.y - 12 - 10 });
  add('penalty_area_width', at(-px, py), at(-px, -py), { x: 16, y: 0 });
  const r = field.center_circle_radius * Math.SQRT1_2;
  const rim = at(r, r);
  add('center_circle_radius', at(0, 0), rim, { x: 0, y: 0 }, { x: rim.x + BESIDE, y: rim.y - BESIDE }, 'start');
  const mark = at(a - field.goal_center_to_penalty_mark, 0);
  const drop = 16;
  add('goal_center_to_penalty_mark', mark, at(a, 0), { x: 0, y: drop }, { x: at(a * 0.45, 0).x, y: mark.y + drop });
  return dimensions;
}
