// SPDX-License-Identifier: Apache-2.0
// Reproducible random numbers: an attack's seed derives from its name and the run's seed.

/** A hash of a text, 0 .. 2^32 - 1. */
function hashOf(text) {
  let hash = 0x811c9dc5;
  for (const byte of Buffer.from(text)) hash = Math.imul(hash ^ byte, 0x01000193) >>> 0;
  return hash;
}

export class Random {
  #state;
  constructor(seed, name = '') {
    this.#state = (hashOf(name) ^ Math.imul(seed, 0x9e3779b1)) >>> 0;
  }
  /** A number in [0, 1). */
  next() {
    this.#state = (this.#state + 0x6d2b79f5) >>> 0;
    let x = this.#state;
    x = Math.imul(x ^ (x >>> 15), x | 1);
    x ^= x + Math.imul(x ^ (x >>> 7), x | 61);
    return ((x ^ (x >>> 14)) >>> 0) / 2 ** 32;
  }
  below(count) { return Math.floor(this.next() * count); }
  between(least, most) { return least + this.below(most - least + 1); }
  pick(list) { return list[this.below(list.length)]; }
  bytes(count) { return Buffer.from(Array.from({ length: count }, () => this.below(256))); }

  /** A number that is difficult for parsers. */
  number() {
    return this.pick([0, -0, 1, -1, 1e-300, 1e300, -1e300, NaN, Infinity, -Infinity, 2 ** 31, -(2 ** 31), 2 ** 53, 0.1, 12345.678, (this.next() - 0.5) * 1e5]);
  }

  /** The bytes with some changed, removed, duplicated or cut off. */
  mutated(bytes) {
    let out = Buffer.from(bytes);
    for (let times = this.between(1, 4); times > 0; --times) {
      const at = this.below(out.length + 1);
      const length = this.below(9);
      out = this.pick([
        () => { if (out.length > 0) out[this.below(out.length)] ^= 1 << this.below(8); return out; },
        () => { if (out.length > 0) out[this.below(out.length)] = this.pick([0, 1, 0x7f, 0x80, 0xff]); return out; },
        () => Buffer.concat([out.subarray(0, at), this.bytes(length), out.subarray(at)]),
        () => Buffer.concat([out.subarray(0, at), out.subarray(at + length)]),
        () => Buffer.concat([out.subarray(0, at), out.subarray(at, at + 40), out.subarray(at)]),
        () => out.subarray(0, at),
      ])();
    }
    return out;
  }
}
