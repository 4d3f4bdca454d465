// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { SettingsChange, SettingsStep } from '../../api/types';
import { camerasOfSteps } from './stepCameras';

let revision = 9;
const step = (...changes: SettingsChange[]): SettingsStep => ({ revision: revision--, time: 0, who: 'a', what: '', changes });
const camera = (id: number) => ({ id, source: {} });
const named = (ids: number[], steps: SettingsStep[]) => {
  const cameras = camerasOfSteps({ cameras: ids.map(camera) }, steps);
  return steps.map(({ changes }) => changes.map((change) => cameras.get(change)));
};
const gain = (index: number): SettingsChange => ({ op: 'replace', path: `/cameras/${index}/source/gain`, before: 1, after: 2 });

describe('the cameras of steps', () => {
  it('are those now when none came or went', () => expect(named([4, 7], [step(gain(1)), step(gain(0))])).toEqual([[7], [4]]));

  it('are those of the time before one was removed', () => {
    const removed: SettingsChange = { op: 'remove', path: '/cameras/0', before: camera(3) };
    expect(named([4], [step(gain(0)), step(removed), step(gain(0), gain(1))])).toEqual([[4], [3], [3, 4]]);
  });

  it('are those of the time before one was added, got another id, or all were replaced', () => {
    const added: SettingsChange = { op: 'add', path: '/cameras/1', after: camera(5) };
    expect(named([4, 5], [step(added), step(gain(0))])).toEqual([[5], [4]]);
    const renamed: SettingsChange = { op: 'replace', path: '/cameras/0/id', before: 1, after: 4 };
    expect(named([4], [step(renamed, gain(0)), step(gain(0))])).toEqual([[4, 4], [1]]);
    const list: SettingsChange = { op: 'replace', path: '/cameras', before: [camera(8)], after: [camera(4)] };
    expect(named([4], [step(list), step(gain(0))])).toEqual([[null], [8]]);
    const all: SettingsChange = { op: 'replace', path: '', before: { cameras: [camera(8)] }, after: { cameras: [camera(4)] } };
    expect(named([4], [step(all), step(gain(0))])).toEqual([[null], [8]]);
  });

  it('are nobody for what is of no camera, or of one that is not known', () => {
    const site: SettingsChange = { op: 'replace', path: '/site', before: 'a', after: 'b' };
    expect(named([4], [step(site, gain(6))])).toEqual([[null, null]]);
  });
});
