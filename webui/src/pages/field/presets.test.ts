// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { divisionB } from '../../testing/samples';
import type { Json } from '../../settings/pointer';
import { differences, presetOperations, shortName } from './presets';

const preset = { name: 'division-a', description: 'Division A, 2026', field: { ...divisionB, field_length: 12000, field_lines: null } };
const asJson = (value: unknown) => value as Json;

describe('presets', () => {
  it('name what they change and nothing else', () => {
    expect(differences(asJson(divisionB), preset)).toEqual([{ key: 'field_length', before: 9000, after: 12000 }]);
    expect(differences(asJson(preset.field), preset)).toEqual([]);
  });
  it('take hand-made lines away', () => {
    const own = [{ name: 'Tape', x1: 0, y1: 0, x2: 1, y2: 0, thickness: 0 }];
    expect(differences(asJson({ ...preset.field, field_lines: own }), preset)).toEqual([{ key: 'field_lines', before: own, after: null }]);
  });
  it('are one patch', () => {
    const changes = differences(asJson(divisionB), preset);
    expect(presetOperations(asJson({ field: divisionB }), changes)).toEqual([{ op: 'replace', path: '/field/field_length', value: 12000 }]);
  });
  it('have short names', () => {
    expect(shortName(preset)).toBe('Division A');
  });
});
