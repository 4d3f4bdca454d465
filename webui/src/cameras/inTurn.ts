// SPDX-License-Identifier: Apache-2.0
// The service opens one camera of a kind at a time: those that wait here cannot run out of its patience.
let queue: Promise<unknown> = Promise.resolve();

export function inTurn<T>(work: () => Promise<T>): Promise<T> {
  const result = queue.then(work);
  queue = result.catch(() => {});
  return result;
}
