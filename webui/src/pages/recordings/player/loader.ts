// SPDX-License-Identifier: Apache-2.0
// Loads what is wanted now, the most important first, at most two at a time. Outdated wants are dropped: over a slow
// link, frames are skipped instead of queued.
import { indexAt } from './clock';

export interface Want<T> {
  key: string;
  ask: () => Promise<T>;
  /** Decides how many results are kept; see `limits`. */
  kind: string;
}

export const MOST_AT_ONCE = 2;
/** A failed request is repeated only after this pause. */
const PAUSE_MS = 1500;
/** Weight of a new measurement. */
const SMOOTH = 0.3;

export class Loader {
  /** By key, least recently used first. */
  private readonly kept = new Map<string, { kind: string; value: unknown }>();
  private readonly onTheWay = new Set<string>();
  private readonly failedAt = new Map<string, number>();
  private wanted: readonly Want<unknown>[] = [];
  private isOver = false;
  /** Approximate duration of a request. */
  seconds = 0.02;

  /** `limits`: number of results kept per kind. `changed` is called for each answer, `failed` for each error. */
  constructor(private readonly limits: Readonly<Record<string, number>>, private readonly changed: () => void, private readonly failed: (error: unknown) => void) {}

  get<T>(key: string): T | undefined {
    const one = this.kept.get(key);
    if (!one) return undefined;
    this.kept.delete(key);
    this.kept.set(key, one);
    return one.value as T;
  }
  has(key: string): boolean { return this.kept.has(key); }
  get busy(): number { return this.onTheWay.size; }

  /** Replaces the previous wants. */
  want(list: readonly Want<unknown>[]): void {
    this.wanted = list;
    this.pump();
  }

  end(): void {
    this.isOver = true;
    this.wanted = [];
  }

  private pump(): void {
    const now = performance.now();
    for (const want of this.wanted) {
      if (this.isOver || this.onTheWay.size >= MOST_AT_ONCE) return;
      if (this.kept.has(want.key) || this.onTheWay.has(want.key) || now - (this.failedAt.get(want.key) ?? -Infinity) < PAUSE_MS) continue;
      void this.load(want);
    }
  }

  private async load({ key, kind, ask }: Want<unknown>): Promise<void> {
    this.onTheWay.add(key);
    const began = performance.now();
    try {
      const value = await ask();
      this.seconds += SMOOTH * ((performance.now() - began) / 1000 - this.seconds);
      this.failedAt.delete(key);
      this.kept.set(key, { kind, value });
      this.forgetOldest(kind);
      this.onTheWay.delete(key);
      if (!this.isOver) this.changed();
    } catch (error) {
      this.failedAt.set(key, performance.now());
      this.onTheWay.delete(key);
      if (!this.isOver) this.failed(error);
    }
    this.pump();
  }

  private forgetOldest(kind: string): void {
    const limit = this.limits[kind] ?? Infinity;
    const keys = [...this.kept].filter(([, one]) => one.kind === kind).map(([key]) => key);
    for (const key of keys.slice(0, Math.max(0, keys.length - limit))) this.kept.delete(key);
  }
}

/** Image width to request: reduced over a slow link while the image changes, otherwise sharp. */
export function widthFor(sharp: number, load_s: number, moves: boolean): number {
  if (!moves || load_s < 0.2) return sharp;
  return Math.min(sharp, Math.max(240, Math.round(sharp / (load_s < 0.5 ? 2 : 4))));
}

/**
 * What to load ahead: indices of `times`, nearest first. While playing, they are one loading time of an image apart;
 * while paused, they are the neighbours to which the user may step.
 */
export function ahead(times: readonly number[], position: number, speed: number, load_s: number, isPlaying: boolean): number[] {
  const here = indexAt(times, position);
  if (here < 0) return [];
  if (!isPlaying) return [here + 1, here - 1, here + 2].filter((i) => i >= 0 && i < times.length);
  const out: number[] = [];
  for (let k = 1; k <= 4; k++) {
    const i = Math.max(indexAt(times, position + k * speed * load_s), (out.at(-1) ?? here) + 1);
    if (i >= times.length) break;
    out.push(i);
  }
  return out;
}

/** Over a slow link, a loaded image replaces the current one if it is earlier by at most this, or more if loading is slow. */
const LEAST_BACK_S = 0.5;
/**
 * Index of the image to show: the current one if it is loaded; otherwise, while playing, the newest loaded one before it
 * that is not too old. -1: keep the last one.
 */
export function bestOf(times: readonly number[], position: number, speed: number, load_s: number, isPlaying: boolean, isThere: (i: number) => boolean): number {
  const here = indexAt(times, position);
  if (here < 0 || isThere(here)) return here;
  if (!isPlaying) return -1;
  const oldest = times[here]! - Math.max(LEAST_BACK_S, 3 * load_s) * Math.max(1, speed);
  for (let i = here - 1; i >= 0 && times[i]! >= oldest; i--) if (isThere(i)) return i;
  return -1;
}
