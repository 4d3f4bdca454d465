// SPDX-License-Identifier: Apache-2.0

const FIRST_MS = 500;
const LONGEST_MS = 5000;

/** Exponential backoff, ms, with jitter so that many panels do not reconnect at the same moment. */
export function backoffMs(attempt: number, random: number = Math.random()): number {
  return Math.min(LONGEST_MS, FIRST_MS * 2 ** attempt) * (0.75 + 0.5 * random);
}
