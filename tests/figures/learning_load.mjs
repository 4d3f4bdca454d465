// SPDX-License-Identifier: Apache-2.0
// The cost of learning colours for the pipeline: its latency with and without continuous learning, measured from the
// packets to the teams (t_sent - t_capture). Prints a Markdown table.
//   node learning_load.mjs [seconds of each block; default 10]
import { setTimeout as pause } from 'node:timers/promises';
import { createService } from '../e2e/service.mjs';
import { largerCamera, missing, percentile, receivePackets } from './packets.mjs';

const BLOCK_S = Number(process.argv[2] ?? 10);
/** The panel's polling interval. */
const POLL_MS = 500;
const ROUNDS = 6; // each: without, with, without; interleaved so that drift of the machine affects all

const service = await createService('239.255.77.91');
service.settings.cameras = [largerCamera(service.settings.cameras[0])];
const packets = await receivePackets(service);

const learning = async (method, path = '') => {
  const answer = await fetch(service.address(`api/cameras/0/colors/learning${path}`), { method });
  if (!answer.ok) throw new Error(`${method} learning${path}: ${await answer.text()}`);
  return answer.json();
};

/** Learns continuously; the returned function stops it and resolves to the number of runs. */
function learner() {
  let ending = false;
  const done = (async () => {
    let count = 0;
    while (!ending) {
      await learning('POST');
      while ((await learning('GET')).state !== 'done') await pause(POLL_MS);
      await learning('POST', '/reject');
      ++count;
    }
    return count;
  })();
  return () => { ending = true; return done; };
}

try {
  await service.start();
  await service.statusBecomes(({ cameras }) => cameras[0].frames > 300);

  const kinds = ['without', 'with', 'without, again'].map((name) => ({ name, latencies: [], single: [], lost: 0 }));
  let learnings = 0;
  for (let round = 0; round < ROUNDS; round++) {
    for (const kind of kinds) {
      const end = kind.name === 'with' ? learner() : async () => 0;
      const seen = await packets.block(BLOCK_S);
      learnings += await end();
      kind.latencies.push(...seen.map(({ latencyMs }) => latencyMs));
      kind.single.push(percentile(seen.map(({ latencyMs }) => latencyMs), 0.99));
      kind.lost += missing(seen);
    }
  }
  console.log(`One camera, 1280 x 1024, 60 Hz; ${ROUNDS} times ${BLOCK_S} s each, in turn; ${learnings} learnings of three pictures\n`);
  console.log('| learning | frames | missing | latency p50, ms | p99, ms | median of the blocks\' p99 | p99 of single blocks |');
  console.log('|---|---:|---:|---:|---:|---:|---:|');
  for (const { name, latencies, single, lost } of kinds) {
    const range = `${Math.min(...single).toFixed(2)} to ${Math.max(...single).toFixed(2)}`;
    console.log(`| ${name} | ${latencies.length} | ${lost} | ${percentile(latencies, 0.5).toFixed(3)} | ${percentile(latencies, 0.99).toFixed(3)} | ${percentile(single, 0.5).toFixed(3)} | ${range} |`);
  }
} finally {
  packets.close();
  await service.end();
}
