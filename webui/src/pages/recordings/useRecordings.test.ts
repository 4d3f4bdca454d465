// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Recordings } from '../../api/types';
import { logPath, newestState } from './useRecordings';

const used = (used_bytes: number) => ({ disk: { used_bytes } }) as Recordings;
/** An answer that arrives on demand. */
function later() {
  let come: (answer: Recordings) => void = () => {};
  let fail: (error: Error) => void = () => {};
  const answer = new Promise<Recordings>((resolve, reject) => { come = resolve; fail = reject; });
  return { ask: () => answer, come, fail };
}

describe('the state of recordings', () => {
  it('is not overtaken by an older answer', async () => {
    const { state, look } = newestState();
    const [poll, change] = [later(), later()];
    const waits = [look(poll.ask), look(change.ask)];
    change.come(used(2));
    await waits[1];
    poll.come(used(1));
    await waits[0];
    expect(state.value).toEqual(used(2));
  });
  it('stays when a request fails, which is told', async () => {
    const { state, look } = newestState();
    await look(() => Promise.resolve(used(1)));
    const refused = later();
    const wait = look(refused.ask);
    refused.fail(new Error('the disk is full'));
    await expect(wait).rejects.toThrow('the disk is full');
    expect(state.value).toEqual(used(1));
  });
});

it('names a log in an address', () => {
  expect(logPath('2026-07-03_14-05_a b.log.gz')).toBe('recordings/logs/2026-07-03_14-05_a%20b.log.gz');
});
