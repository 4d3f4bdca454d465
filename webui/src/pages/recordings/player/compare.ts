// SPDX-License-Identifier: Apache-2.0
// The result of a comparison, as texts and marks.
import type { Comparison, CompareWith, ComparisonResult, Difference } from '../../../api/types';
import { decimal, figure, plural } from '../../../format';
import { turnPixel, type Size, type Turn } from '../../../geometry/turn';
import type { Marks } from '../../../picture/marks';
import type { TimedEvent } from '../timeline';

export const compareTitles: Record<CompareWith, string> = {
  recorded_settings: 'With the recorded settings',
  settings_now: 'With the current settings',
  learnt_colors: 'With the learnt colours, not accepted yet',
};

const KINDS = { found: 'found', lost: 'lost', moved: 'moved', id: 'with a changed number' } as const;
export const kinds = [
  { kind: 'found', title: 'Found' }, { kind: 'lost', title: 'Lost' }, { kind: 'moved', title: 'Moved' }, { kind: 'id', title: 'Changed number' },
] as const;

/** "31 of 742 frames differ: 3 found, 40 lost, 12 moved by up to 4.1 mm." */
export function resultText(result: ComparisonResult): string {
  const { frames, frames_that_differ, found, lost, moved, id_changed, largest_mm } = result;
  if (frames_that_differ === 0) return `Nothing differs in ${plural(frames, 'frame')}.`;
  const parts = [
    found && `${figure(found)} found`, lost && `${figure(lost)} lost`,
    moved && `${figure(moved)} moved by up to ${decimal(largest_mm, 1)} mm`,
    id_changed && `${figure(id_changed)} with a changed number`,
  ].filter(Boolean);
  return `${figure(frames_that_differ)} of ${plural(frames, 'frame')} ${frames_that_differ === 1 ? 'differs' : 'differ'}${parts.length ? `: ${parts.join(', ')}` : ''}.`;
}

/** "yellow 3 lost", "ball moved 2.1 mm" */
export function differenceText({ what, kind, by_mm, by_deg }: Difference): string {
  if (kind !== 'moved') return `${what} ${KINDS[kind]}`;
  // A robot that only turned has not moved by a distance.
  return by_mm < 0.05 && by_deg >= 0.05 ? `${what} turned ${decimal(by_deg, 1)}°` : `${what} moved ${decimal(by_mm, 1)} mm`;
}

export const differenceEvents = (differences: readonly Difference[]): TimedEvent[] =>
  differences.map((one) => ({ time_s: one.time_s, kind: 'difference', text: differenceText(one) }));

/** Whether the comparison belongs to that clip and camera. */
export const isOf = (comparison: Comparison | null, clip: string, camera: number): boolean =>
  comparison !== null && comparison.state !== 'idle' && comparison.clip === clip && comparison.camera === camera;

export interface Ring {
  kind: Difference['kind'];
  x: number;
  y: number;
  radius: number;
  difference: Difference;
}

/** Radius of a ring as a share of the image's width, if no robot of known size is visible. */
const BLIND_RADIUS = 0.025;
/** A ring surrounds what is already drawn. */
const WIDER = 1.5;

/** Rings around the differences, in pixels of the (turned) image. */
export function ringsOf(differences: readonly Difference[], { robots, balls }: Marks, picture: Size, turn: Turn): Ring[] {
  const most = (list: readonly { radius: number }[]) => Math.max(0, ...list.map(({ radius }) => radius));
  const [robot, ball] = [most(robots), most(balls)];
  return differences.map((difference) => {
    const { x, y } = turnPixel(turn, picture, { x: difference.pixel_x, y: difference.pixel_y });
    const size = difference.what === 'ball' ? ball || robot / 2 : robot;
    return { kind: difference.kind, x, y, radius: WIDER * (size || BLIND_RADIUS * picture.width), difference };
  });
}
