// SPDX-License-Identifier: Apache-2.0
// Runs tasks one after the other. The service opens one camera of a backend at a time; requests that wait here cannot
// time out there.
let queue: Promise<unknown> = Promise.resolve();

export function inTurn<T>(work: () => Promise<T>): Promise<T> {
  const result = queue.then(work);
  queue = result.catch(() => {});
  return result;
}
