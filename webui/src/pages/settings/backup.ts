// SPDX-License-Identifier: Apache-2.0
// The contents of a backup, as texts.
import type { BackupContents } from '../../api/types';
import { clockTime, figure, plural } from '../../format';

export interface Row {
  name: string;
  text: string;
}

const listed = (names: string[]) => names.join(', ') || 'none';

function passwordsText({ passwords, keeps_passwords }: BackupContents): string {
  if (!passwords) return 'none';
  return keeps_passwords ? 'yes, but this computer keeps its own' : 'yes; sign in with them afterwards';
}

export function heldIn(contents: BackupContents, now = new Date()): Row[] {
  return [
    { name: 'Made', text: clockTime(contents.time, now) },
    { name: 'Site', text: contents.site || 'no name' },
    { name: 'Computer', text: contents.computer },
    { name: 'Program', text: `ssl-visiond ${contents.version}` },
    { name: 'Cameras', text: listed(contents.cameras.map(({ id, name }) => (name ? `${id} (${name})` : String(id)))) },
    { name: 'Colour tables', text: figure(contents.tables) },
    { name: 'Profiles', text: listed(contents.profiles) },
    { name: 'Calibrations', text: figure(contents.calibrations) },
    { name: 'History', text: plural(contents.steps, 'step') },
    { name: 'Passwords', text: passwordsText(contents) },
  ];
}

/** The panel's new port, if the backup changes it: open panels then lose the service. Null: no change. */
export function movesTo({ changes }: BackupContents): number | null {
  const port = changes.find(({ path }) => path === '/panel/port')?.after;
  return typeof port === 'number' && port > 0 ? port : null;
}
