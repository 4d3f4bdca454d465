// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import type { LogMoment } from '../../../api/types';
import { divisionB, robot } from '../../../testing/samples';
import { camerasAt, camerasOfLog, fieldOfLog, tracksOfLog } from './moments';

const moment = (changes: Partial<LogMoment> = {}): LogMoment => ({
  time_s: 12.3, cameras: [{ id: 2, time_s: 12.2, robots: [{ ...robot(), team: 'blue', id: 1, orientation: null }], balls: [] }],
  tracked: null, referee: null, field: null, ...changes,
});

it('says how old each camera’s report was', () => {
  const [one] = camerasAt([{ camera: 3, number: 9, time_s: 1, width: 1, height: 1, robots: [robot()], balls: [] }], 1.25);
  expect(one).toMatchObject({ camera: 3, at: -250, detections: { frame: 9 } });
});

it('takes a log’s moment as cameras and tracks', () => {
  const [one] = camerasOfLog(moment());
  expect(one!.at).toBeCloseTo(-100);
  expect(camerasAt([{ camera: 3, number: 9, time_s: 1, width: 1, height: 1, robots: [{ ...robot(), id: null, orientation: null }], balls: [] }], 1)[0]!.detections.robots[0]).toMatchObject({ id: -1, orientation: NaN });
  // A robot with an unknown heading is drawn without one.
  expect(one!.detections.robots[0]!.orientation).toBeNaN();
  expect(tracksOfLog(moment())).toBeNull();
  const tracks = tracksOfLog(moment({ tracked: { robots: [{ team: 'yellow', id: 4, x: 0, y: 0, orientation: 1, vx: 2, vy: 3 }], ball: { x: 5, y: 6, z: 7, vx: 8, vy: 9 } } }))!;
  expect(tracks.robots[0]).toMatchObject({ id: 4, vx: 2, vy: 3, visibility: 1 });
  expect(tracks.balls).toEqual([{ x: 5, y: 6, z: 7, vx: 8, vy: 9, vz: 0, visibility: 1 }]);
});

it('draws the field of the log', () => {
  expect(fieldOfLog(null, divisionB)).toBe(divisionB);
  expect(fieldOfLog(moment({ field: { length: 9000, width: 6000 } }), divisionB)).toBe(divisionB);
  expect(fieldOfLog(moment({ field: { length: 12000, width: 9000 } }), divisionB)).toMatchObject({ field_length: 12000, field_width: 9000, field_lines: null });
});
