// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { patchOf, readTree, sectionsOf } from './changes';

const tree = { site: 'A', cameras: [{ id: 4 }] };

describe('changes', () => {
  it('come in sections', () => {
    const sections = sectionsOf(tree, [
      { op: 'replace', path: '/site', before: 'A', after: 'B' },
      { op: 'replace', path: '/cameras/0/calibration', before: null, after: {} },
      { op: 'replace', path: '/cameras/0/stages/segment/threads', before: 1, after: 2 },
      { op: 'replace', path: '/cameras/0/stages/publish/x', before: 1, after: 2 },
      { op: 'add', path: '/cameras/1', after: {} },
    ]);
    expect(sections.map(({ title, changes, isCalibration }) => [title, changes.length, isCalibration])).toEqual([
      ['Site', 1, false], ['Camera 4 · Calibration', 1, true], ['Camera 4 · Stages', 2, false], ['Camera no. 1', 1, false],
    ]);
  });
  it('become a patch', () => {
    expect(patchOf([{ op: 'replace', path: '/a', before: 1, after: null }, { op: 'remove', path: '/b', before: 2 }]))
      .toEqual([{ op: 'replace', path: '/a', value: null }, { op: 'remove', path: '/b' }]);
  });
  it('are read from files', () => {
    expect(readTree('a.json', '{"site": "B"}')).toEqual({ settings: { site: 'B' } });
    expect(readTree('a.json', '[1]')).toEqual({ error: 'a.json contains no settings: expected an object { … }' });
    expect(readTree('a.json', '{"site":')).toMatchObject({ error: expect.stringMatching(/^a\.json is not valid JSON: /) });
  });
});
