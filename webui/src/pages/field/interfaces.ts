// SPDX-License-Identifier: Apache-2.0
import type { NetworkInterface } from '../../api/types';

export interface InterfaceChoice {
  value: string;
  text: string;
}

function factOf(card: NetworkInterface): string {
  if (!card.is_up) return 'down';
  if (!card.has_link) return 'no link: check the cable';
  if (!card.addresses.length) return 'no IPv4 address';
  const addresses = card.addresses.join(', ');
  if (card.is_loopback) return `${addresses}, this computer only`;
  return card.multicast ? addresses : `${addresses}, no multicast`;
}

/** The cards to choose from: those that can send first, and the configured one even if it is missing. */
export function interfaceChoices(cards: NetworkInterface[], set: string, none: string): InterfaceChoice[] {
  const canSend = (card: NetworkInterface) => card.has_link && card.addresses.length > 0;
  const choices = [...cards].sort((one, other) => Number(canSend(other)) - Number(canSend(one)))
    .map((card) => ({ value: card.name, text: `${card.name} (${factOf(card)})` }));
  const byAddress = cards.find(({ addresses }) => addresses.includes(set));
  if (byAddress) choices.unshift({ value: set, text: `${set} (on ${byAddress.name})` });
  else if (set !== '' && !cards.some(({ name }) => name === set)) choices.unshift({ value: set, text: `${set} (not present)` });
  return [{ value: '', text: none }, ...choices];
}
