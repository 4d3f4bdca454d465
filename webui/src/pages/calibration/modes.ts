// SPDX-License-Identifier: Apache-2.0
export type Mode = 'calibrate' | 'together' | 'masks';

export const modes: { name: Mode; title: string }[] = [
  { name: 'calibrate', title: 'Calibrate' },
  { name: 'together', title: 'Together' },
  { name: 'masks', title: 'Masks' },
];
