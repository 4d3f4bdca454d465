// SPDX-License-Identifier: Apache-2.0
// COUNT viewers of one camera in a process of lowest priority: real ones run on other computers.
//   node viewers.mjs PORT COUNT PREVIEW_JSON
// Writes `{"pictures": ..., "bytes": ...}`, the totals of all viewers, when its input ends.
import { setPriority } from 'node:os';
import { openViewer } from './viewer.mjs';

setPriority(19);
const [, , port, count, preview] = process.argv;
const viewers = [];
for (let i = 0; i < Number(count); i++) viewers.push(await openViewer(Number(port), JSON.parse(preview)));
process.stdout.write('watching\n');
process.stdin.resume();
process.stdin.on('end', () => {
  const sum = (name) => viewers.reduce((total, viewer) => total + viewer[name], 0);
  process.stdout.write(`${JSON.stringify({ pictures: sum('pictures'), bytes: sum('bytes') })}\n`);
  process.exit(0);
});
