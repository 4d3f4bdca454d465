// SPDX-License-Identifier: Apache-2.0
// Texts on what another vision in our group means for the teams.
import type { OtherVision } from '../../api/types';
import { titleOf } from '../../settings/schema';

export interface Finding {
  kind: 'bad' | 'info';
  text: string;
  fix: string;
}

const list = (words: (string | number)[]) => (words.length < 2 ? words.join('') : `${words.slice(0, -1).join(', ')} and ${words.at(-1)}`);

export const sharedIds = (other: OtherVision, ours: number[]): number[] => other.cameras.filter((id) => ours.includes(id));

export function findings(other: OtherVision, ours: number[]): Finding[] {
  const shared = sharedIds(other, ours);
  const out: Finding[] = [];
  if (shared.length) {
    out.push({
      kind: 'bad', text: `Sends ${shared.length > 1 ? 'cameras' : 'camera'} ${list(shared)}, as this service does.`,
      fix: 'Teams mix up the detections of both. Give each camera its own id, or stop one of the vision services.',
    });
  }
  if (other.field_conflicts.length) {
    const sizes = other.field_conflicts.map(({ name, ours: here, theirs }) => `${titleOf(name).toLowerCase()} ${theirs} mm (here ${here} mm)`);
    out.push({ kind: 'bad', text: `Sends another field: ${list(sizes)}.`, fix: 'Teams receive both in turn. Set the same sizes, or stop one of the vision services.' });
  }
  if (!other.is_named) out.push({ kind: 'info', text: 'Its cameras are shown, but not used for tracks.', fix: `If it is a computer of this field, add ${other.address} to the field's other computers.` });
  else if (!out.length) out.push({ kind: 'info', text: 'Its cameras are used for tracks.', fix: 'The settings name it as one of this field\'s other computers.' });
  return out;
}
