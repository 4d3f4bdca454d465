// SPDX-License-Identifier: Apache-2.0
import { readFileSync, readdirSync, readlinkSync } from 'node:fs';

/** The UDP ports that the service currently has open. */
function portsOf(pid) {
  const own = new Set();
  for (const fd of readdirSync(`/proc/${pid}/fd`)) {
    try {
      own.add(/^socket:\[(\d+)\]$/.exec(readlinkSync(`/proc/${pid}/fd/${fd}`))?.[1]);
    } catch { /* closed meanwhile */ }
  }
  const rows = readFileSync('/proc/net/udp', 'latin1').split('\n').slice(1).map((row) => row.trim().split(/\s+/));
  return [...new Set(rows.filter((row) => row.length > 9 && own.has(row[9])).map(([, local]) => parseInt(local.split(':')[1], 16)))];
}

export default {
  name: 'datagrams to all ports',
  about: 'random and empty datagrams, large and small, to every UDP port of the service',
  async run({ socketAt, random, pid, isOver, pause }) {
    const { send } = await socketAt('127.0.0.111');
    while (!isOver()) {
      for (const port of portsOf(pid())) {
        for (let i = 0; i < 5; ++i) send(random.bytes(random.pick([0, 1, 8, 64, 1400])), port, '127.0.0.1');
      }
      await pause(20);
    }
  },
};
