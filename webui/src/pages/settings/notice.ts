// SPDX-License-Identifier: Apache-2.0
// One line about the last action, with Undo. It stays until the next one, or until it is closed.
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

/** Why an action failed; empty on success. */
export function refusal(outcome: Outcome): string {
  if (outcome.kind === 'saved') return '';
  if (outcome.kind === 'stale') return `${outcome.step.who} changed the same setting at ${clockTime(outcome.step.time)}. Nothing was overwritten.`;
  return `${outcome.text}. Nothing was changed.`;
}

export function sayOutcome(outcome: Outcome, done: string, undo?: () => Promise<void>): void {
  const text = refusal(outcome);
  if (text) sayBad(text);
  else if (outcome.kind === 'saved' && outcome.refused) sayBad(`${done}, but rejected by the camera: ${outcome.refused.join('; ')}`);
  else say(done, undo);
}

/** Reports what was saved, and offers to undo exactly that. */
export function saySaved(outcome: Outcome, done: string): void {
  const step = outcome.kind === 'saved' ? outcome.revision : undefined;
  sayOutcome(outcome, done, step === undefined ? undefined : async () => sayOutcome(await undoStep(step), 'Undone'));
}
