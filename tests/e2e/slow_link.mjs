// SPDX-License-Identifier: Apache-2.0
// A slow or broken link between browser and service: a TCP proxy. Chromium's own throttling does not cover all
// WebSocket traffic.
import { once } from 'node:events';
import { connect, createServer } from 'node:net';

/**
 * A proxy in front of `port()` of this computer. `kbps`: total rate of all connections towards the browser, in kbit/s;
 * Infinity: no limit. `slice_ms`: interval of forwarding. `burst_ms`: unused capacity of up to this duration can be
 * used later, because this process does not always run in time.
 */
export async function createLink(port, { slice_ms = 20, burst_ms = 200 } = {}) {
  let kbps = Infinity;
  let isCut = false;
  let bytes = 0;
  let free = 0; // bytes that may be forwarded now
  let pumpedAt = performance.now();
  const pairs = new Set();

  /** Round robin, so that no connection starves another. */
  function pump() {
    const rate = kbps * 1000 / 8;
    const now = performance.now();
    free = Math.min(free + rate * (now - pumpedAt) / 1000, Math.max(1500, rate * burst_ms / 1000));
    pumpedAt = now;
    let moved = true;
    while (moved && free > 0) {
      moved = false;
      for (const { client, server } of pairs) {
        if (free <= 0) break;
        if (!server.readableLength || client.writableLength > 16_384) continue;
        const chunk = server.read(Math.min(server.readableLength, Math.max(1, Math.min(1500, Math.floor(free)))));
        if (!chunk) continue;
        client.write(chunk);
        free -= chunk.length;
        bytes += chunk.length;
        moved = true;
      }
    }
    for (const { client, server } of pairs) if (server.readableEnded && !client.writableEnded) client.end();
  }
  const timer = setInterval(pump, slice_ms);

  const listener = createServer((client) => {
    if (isCut) return client.destroy();
    const server = connect({ port: port(), host: '127.0.0.1' });
    const pair = { client, server };
    pairs.add(pair);
    const end = () => { pairs.delete(pair); client.destroy(); server.destroy(); };
    client.on('error', end).on('close', end).on('data', (data) => server.write(data)).on('end', () => server.end());
    server.on('error', end).on('close', () => { if (server.destroyed) end(); });
    server.on('readable', pump);
  }).listen(0, '127.0.0.1');
  await once(listener, 'listening');

  return {
    address: (path = '') => `http://127.0.0.1:${listener.address().port}/${path}`,
    /** Bytes forwarded to the browser so far. */
    bytes: () => bytes,
    limit(next) { kbps = next; },
    /** Closes all connections and refuses new ones. */
    cut() {
      isCut = true;
      for (const { client, server } of pairs) { client.destroy(); server.destroy(); }
      pairs.clear();
    },
    mend() { isCut = false; },
    async end() {
      clearInterval(timer);
      this.cut();
      listener.close();
      await once(listener, 'close');
    },
  };
}
