// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { findings } from './others';

const other = { address: '10.0.0.3', is_named: true, silent_s: 0.1, cameras: [1, 2, 5], field_conflicts: [] };

describe('another vision', () => {
  it('is told which camera ids it shares', () => {
    expect(findings(other, [1, 5]).map(({ kind, text }) => [kind, text])).toEqual([['bad', 'Sends cameras 1 and 5, as this service does.']]);
  });
  it('is told which sizes differ', () => {
    const [finding] = findings({ ...other, field_conflicts: [{ name: 'field_length', ours: 9000, theirs: 12000 }] }, [0]);
    expect(finding!.text).toBe('Sends another field: field length 12000 mm (here 9000 mm).');
  });
  it('may be no trouble', () => {
    expect(findings(other, [0])).toMatchObject([{ kind: 'info', text: 'Its cameras are used for tracks.' }]);
  });
  it('is not used until it is named', () => {
    const [finding] = findings({ ...other, is_named: false }, [0]);
    expect(finding).toMatchObject({ kind: 'info', text: 'Its cameras are shown, but not used for tracks.' });
    expect(finding!.fix).toContain('10.0.0.3');
  });
});
