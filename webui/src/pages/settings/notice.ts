// SPDX-License-Identifier: Apache-2.0
// One line on what was just done, with the way back. It stays until the next, or until it is closed.
import { shallowRef } from 'vue';
import { clockTime } from '../../format';
import { undoStep, type Outcome } from '../../state/settings';

export interface Notice {
  text: string;
  isBad?: boolean;
  undo?: () => Promise<void>;
}

export const notice = shallowRef<Notice | null>(null);

export const say = (text: string, undo?: () => Promise<void>) => { notice.value = { text, undo }; };
export const sayBad = (text: string) => { notice.value = { text, isBad: true }; };

/** Why something did not happen, for people; empty when it did. */
export function refusal(outcome: Outcome): string {
  if (outcome.kind === 'saved') return '';
  if (outcome.kind === 'stale') return `${outcome.step.who} changed the same setting at ${clockTime(outcome.step.time)}. Nothing was overwritten.`;
  return `${outcome.text}. Nothing was changed.`;
}

export function sayOutcome(outcome: Outcome, done: string, undo?: () => Promise<void>): void {
  const text = refusal(outcome);
  if (text) sayBad(text);
  else if (outcome.kind === 'saved' && outcome.refused) sayBad(`${done}, but not taken by the camera: ${outcome.refused.join('; ')}`);
  else say(done, undo);
}

/** Says what was saved, and offers to take just that back. */
export function saySaved(outcome: Outcome, done: string): void {
  const step = outcome.kind === 'saved' ? outcome.revision : undefined;
  sayOutcome(outcome, done, step === undefined ? undefined : async () => sayOutcome(await undoStep(step), 'Undone'));
}
