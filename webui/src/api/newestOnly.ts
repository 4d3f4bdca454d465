// SPDX-License-Identifier: Apache-2.0

/**
 * Sends values one after the other. While a request is pending, only the newest value of each name is kept: a slider
 * may move faster than a camera answers.
 */
export function newestOnly<T>(send: (name: string, value: T) => Promise<void>, atRest: () => void) {
  const waiting = new Map<string, T>();
  let busy = false;

  async function run(): Promise<void> {
    busy = true;
    for (let next = waiting.entries().next(); !next.done; next = waiting.entries().next()) {
      const [name, value] = next.value;
      waiting.delete(name);
      await send(name, value);
    }
    busy = false;
    atRest();
  }

  return {
    put(name: string, value: T): void {
      waiting.set(name, value);
      if (!busy) void run();
    },
    isWaiting: (name: string) => waiting.has(name),
  };
}
