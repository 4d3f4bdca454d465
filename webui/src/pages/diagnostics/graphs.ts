// SPDX-License-Identifier: Apache-2.0
// The graphs of the timeline: curves, colours, scales.
import { figure, latencyMs } from '../../format';
import { outages, type Figure, type Series } from './timeline';

/** Margins of every graph in CSS pixels, equal so that their times align. */
export const LEFT = 44;
export const RIGHT = 12;

export type Scale = (lowest: number | null, highest: number | null) => [number, number];

export interface Curve {
  key: string;
  /** Name of a colour token. */
  colour: string;
  isDashed?: boolean;
  isStepped?: boolean;
  values: readonly (number | null)[];
}

/** A period shaded in a camera's colour. */
export interface Band {
  colour: string;
  from: number;
  to: number;
}

export interface GraphKind {
  key: 'latency' | 'fps' | 'seen' | 'lost';
  title: string;
  unit: string;
  /** The curves of a camera; the second one is dashed. */
  figures: readonly { figure: Figure; name: string }[];
  text: (value: number) => string;
  scale: Scale;
  /** Counts have integer ticks, and steps instead of slopes. */
  isCount?: boolean;
  /** Share of the card's height. */
  height: number;
}

/** From zero to at least `least`. */
export const fromZero = (least: number): Scale => (_, highest) => [0, Math.max(least, (highest ?? 0) * 1.08)];

/** Around the data, but at least `leastSpan` wide: a steady value stays a steady line. */
export const around = (leastSpan: number): Scale => (lowest, highest) => {
  if (lowest === null || highest === null) return [0, leastSpan];
  const spare = Math.max(leastSpan - (highest - lowest), (highest - lowest) * 0.16) / 2;
  const bottom = Math.max(0, lowest - spare);
  return [bottom, Math.max(highest + spare, bottom + leastSpan)];
};

export const graphKinds: readonly GraphKind[] = [
  {
    key: 'latency', title: 'Latency', unit: 'ms', height: 2, text: latencyMs, scale: fromZero(0.1),
    figures: [{ figure: 'latency_p50_ms', name: 'p50' }, { figure: 'latency_p99_ms', name: 'p99' }],
  },
  { key: 'fps', title: 'Frame rate', unit: 'fps', height: 1, text: (value) => value.toFixed(1), scale: around(4), figures: [{ figure: 'fps', name: 'frames' }] },
  {
    key: 'seen', title: 'Seen', unit: 'per frame', height: 1, text: figure, scale: fromZero(2), isCount: true,
    figures: [{ figure: 'robots', name: 'robots' }, { figure: 'balls', name: 'balls' }],
  },
  {
    key: 'lost', title: 'Lost', unit: 'frames per s', height: 1, text: figure, scale: fromZero(2), isCount: true,
    figures: [{ figure: 'dropped', name: 'dropped' }, { figure: 'incomplete', name: 'incomplete' }],
  },
];

const COLOURS = ['--g1', '--g2', '--g3', '--g4', '--g5', '--g6', '--g7', '--g8'];
/** A camera's colour in all graphs; `place` is its index among the cameras. */
export const cameraColour = (place: number) => COLOURS[place % COLOURS.length]!;

export function curvesOf(kind: GraphKind, series: Series, cameras: readonly number[]): Curve[] {
  return cameras.flatMap((camera, place) => kind.figures.map(({ figure: name }, i): Curve => ({
    key: `${camera}-${name}`, colour: cameraColour(place), isDashed: i > 0, isStepped: kind.isCount,
    values: series.cameras.get(camera)?.[name] ?? [],
  })));
}

/** Periods in which cameras were not running. */
export const bandsOf = (series: Series, cameras: readonly number[]): Band[] =>
  cameras.flatMap((camera, place) => outages(series, camera).map(([from, to]) => ({ colour: cameraColour(place), from, to })));

/** A camera's figures at a sample, as a text: "0.40 / 0.75". Null if it was not running. */
export function valuesAt(kind: GraphKind, series: Series, camera: number, sample: number): string | null {
  const texts = kind.figures.map(({ figure: name }) => {
    const value = series.cameras.get(camera)?.[name][sample];
    return typeof value === 'number' ? kind.text(value) : null;
  });
  return texts.every((text) => text === null) ? null : texts.map((text) => text ?? '–').join(' / ');
}
