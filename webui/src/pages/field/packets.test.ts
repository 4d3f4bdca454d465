// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { arrivalsText, latencyOf, programsText, seenRows } from './packets';

const detection = {
  frame_number: 7, t_capture: 100, t_sent: 100.0125, camera_id: 1,
  balls: [{ confidence: 0.875, x: -12.34, y: 0, pixel_x: 1.25, pixel_y: 2, z: 21.5 }],
  robots_blue: [{ confidence: 1, robot_id: 0, x: 1, y: 2, orientation: Math.PI / 2, pixel_x: 3, pixel_y: 4, height: 140 }],
};

describe('the rows of a packet', () => {
  it('have balls first, with degrees and true minus signs', () => {
    expect(seenRows(detection)).toEqual([
      { key: 'ball 0', what: 'Ball', team: null, x: '−12.3', y: '0.0', angle: '–', height: '21.5', pixel: '1.3, 2.0', confidence: '0.88' },
      { key: 'blue 0', what: 'Blue 0', team: 'blue', x: '1.0', y: '2.0', angle: '90.0', height: '140.0', pixel: '3.0, 4.0', confidence: '1.00' },
    ]);
  });
  it('show what a packet leaves out as unknown', () => {
    const [row] = seenRows({ ...detection, balls: undefined, robots_blue: undefined, robots_yellow: [{ confidence: 1, x: 1, y: 2, pixel_x: 3, pixel_y: 4 }] });
    expect(row).toMatchObject({ what: 'Yellow ?', angle: '–', height: '–' });
  });
  it('are none for a frame without a find', () => expect(seenRows({ ...detection, balls: undefined, robots_blue: undefined })).toEqual([]));
});

it('the latency is the packet\'s own', () => expect(latencyOf(detection)).toBeCloseTo(12.5, 3));
it('programs are counted by user', () => {
  expect(programsText([{ user: 'a', address: '::' }, { user: 'b', address: '::' }, { user: 'a', address: '0.0.0.0' }])).toBe('2 sockets of user a, 1 socket of user b');
});
it('packets come by multicast, by broadcast or by both', () => {
  const of = (multicast: boolean, broadcast: boolean) => ({ what: 'vision' as const, address: '10.0.0.2', multicast, broadcast });
  expect(arrivalsText([of(true, false), { ...of(false, true), what: 'game controller' }, of(true, true)])).toBe('vision of 10.0.0.2 by multicast, game controller of 10.0.0.2 by broadcast, vision of 10.0.0.2 by multicast and broadcast');
});
