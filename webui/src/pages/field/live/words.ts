// SPDX-License-Identifier: Apache-2.0
// Texts of the live field.
import type { CameraStatus, FieldKick, FieldNow, FieldTracks, Status, TrackedBall } from '../../../api/types';
import { decimal, duration, plural } from '../../../format';
import { fieldTitle } from '../../../geometry/fieldLines';
import { FLYING_MM, isSeen, speedOf } from './motion';

/** Older tracks are not live. */
export const LIVE_S = 1;

export const metresPerSecond = (mm_s: number): string => decimal(mm_s / 1000, 2);
export const metres = (mm: number): string => decimal(mm / 1000, 2);
/** "1.20, −0.45" */
export const placeText = (x: number, y: number): string => `${metres(x)}, ${metres(y)}`;

/** "0.43 m" for a ball in the air; empty for one on the floor. */
export const heightText = (z_mm: number): string => (z_mm > FLYING_MM ? `${metres(z_mm)} m` : '');

/** "3.4 mm", "12 mm" */
export const apartText = (mm: number): string => `${decimal(mm, mm < 9.95 ? 1 : 0)} mm`;

const TEAMS = { yellow: 'Yellow', blue: 'Blue' } as const;
export const whoText = ({ robot }: Pick<FieldKick, 'robot'>): string => (robot ? `${TEAMS[robot.team]} ${robot.id}` : 'unknown');
export const robotName = ({ team, id }: { team: keyof typeof TEAMS; id: number }): string => `${TEAMS[team]} ${id}`;

function ballText(ball: TrackedBall | undefined): string {
  if (!ball) return 'no ball';
  const height = heightText(ball.z);
  return `the ball at ${placeText(ball.x, ball.y)} m, ${metresPerSecond(speedOf(ball))} m/s${height && `, ${height} high`}${isSeen(ball) ? '' : ', not seen now'}`;
}

/** The field in one sentence, for screen readers. */
export function summaryOf({ robots, balls }: Pick<FieldTracks, 'robots' | 'balls'>, field: Status['field']): string {
  const count = (team: string) => robots.filter((robot) => robot.team === team).length;
  const unseen = robots.filter((robot) => !isSeen(robot)).length;
  return `${fieldTitle(field)}: ${count('yellow')} yellow and ${plural(count('blue'), 'blue robot')}${unseen ? `, ${unseen} of them not seen now` : ''}; ${ballText(balls[0])}`;
}

export interface Missing {
  text: string;
  /** The page where it can be fixed. */
  page?: 'camera' | 'calibration' | 'settings' | 'diagnostics' | 'overview';
  place?: string;
  action?: string;
}

const isUsable = ({ state, calibration }: CameraStatus) => state === 'running' && calibration !== null;

/**
 * Why nothing is tracked; null: something is. `age_s`: age of the tracks when the newest status was sent, null before the
 * first. `now`: null while unknown.
 */
export function missing(status: Status | null, now: Pick<FieldNow, 'stages' | 'other_cameras'> | null, number: number, age_s: number | null): Missing | null {
  if (!status) return { text: 'The service cannot be reached. The panel tries again automatically.' };
  const isTracked = number > 0 && age_s !== null && age_s <= LIVE_S;
  if (isTracked) return null;
  if (now && !now.stages.some(({ name }) => name === 'track')) {
    return now.stages.length
      ? { text: 'The field’s stack has no stage “track”, so nothing is tracked.', page: 'settings', place: 'field/stack', action: 'Field’s stack' }
      : { text: 'The field’s stack is empty, so nothing is tracked.', page: 'settings', place: 'field/stack', action: 'Field’s stack' };
  }
  const hasOthers = (now?.other_cameras ?? []).some(({ is_used }) => is_used);
  if (!hasOthers) {
    const { cameras } = status;
    if (!cameras.length) return { text: 'There is no camera yet.', page: 'overview', action: 'Add a camera' };
    if (!cameras.some(({ calibration }) => calibration)) return { text: 'No camera is calibrated, so nothing can be located on the field.', page: 'calibration', action: 'Calibrate' };
    if (!cameras.some(isUsable)) return { text: 'No calibrated camera sends images.', page: 'overview', action: 'Cameras' };
  }
  if (number === 0 || age_s === null) return { text: 'Nothing has been tracked yet.', page: 'diagnostics', action: 'Diagnostics' };
  return { text: `Nothing new has been tracked for ${duration(age_s)}.`, page: 'diagnostics', action: 'Diagnostics' };
}
