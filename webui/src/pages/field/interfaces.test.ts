// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { interfaceChoices } from './interfaces';

const cards = [
  { name: 'lo', addresses: ['127.0.0.1'], is_up: true, has_link: true, is_loopback: true, multicast: false },
  { name: 'eth1', addresses: [], is_up: false, has_link: false, is_loopback: false, multicast: true },
  { name: 'eth2', addresses: ['10.0.1.2'], is_up: true, has_link: false, is_loopback: false, multicast: true },
  { name: 'eth0', addresses: ['10.0.0.2'], is_up: true, has_link: true, is_loopback: false, multicast: true },
];

describe('network cards to choose from', () => {
  it('say what each is good for, the useless last', () => {
    expect(interfaceChoices(cards, '', 'Automatic').map(({ text }) => text)).toEqual([
      'Automatic', 'lo (127.0.0.1, this computer only)', 'eth0 (10.0.0.2)', 'eth1 (down)', 'eth2 (no link: check the cable)',
    ]);
  });
  it('keep what is set, by address or gone', () => {
    expect(interfaceChoices(cards, '10.0.0.2', '')[1]).toEqual({ value: '10.0.0.2', text: '10.0.0.2 (on eth0)' });
    expect(interfaceChoices(cards, 'eth9', '')[1]).toEqual({ value: 'eth9', text: 'eth9 (not present)' });
    expect(interfaceChoices(cards, 'eth0', '')).toHaveLength(5);
  });
});
