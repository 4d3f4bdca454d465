// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { bytes } from './bytes';

it('names sizes', () => {
  expect([0, 999, 1000, 9960, 999_600, 1_300_000_000, 16e9, 5e15].map(bytes)).toEqual(['0 B', '999 B', '1.0 kB', '10 kB', '1.0 MB', '1.3 GB', '16 GB', '5000 TB']);
});
