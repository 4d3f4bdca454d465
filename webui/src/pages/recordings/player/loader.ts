// SPDX-License-Identifier: Apache-2.0
// Gets what is wanted now, the most important first, and never more than two things at a time. What is not wanted any
// more is never asked for: over a slow link frames are skipped, and nothing queues up.
import { indexAt } from './clock';

export interface Want<T> {
  key: string;
  ask: () => Promise<T>;
  /** How many of the same kind are kept. */
  kind: string;
}

export const MOST_AT_ONCE = 2;
/** After a failure the same thing is not asked for again for so long. */
const PAUSE_MS = 1500;
/** How much a new measurement counts. */
const SMOOTH = 0.3;

export class Loader {
  /** By key; the one that was used longest ago comes first. */
  private readonly kept = new Map<string, { kind: string; value: unknown }>();
  private readonly onTheWay = new Set<string>();
  private readonly failedAt = new Map<string, number>();
  private wanted: readonly Want<unknown>[] = [];
  private isOver = false;
  /** How long an answer takes, about. */
  seconds = 0.02;

  /** `limits`: how much of each kind is kept. `changed` is called with each answer, `failed` with each refusal. */
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

  /** In the place of what was wanted before. */
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

/** How wide an image to ask for: over a slow link a smaller one while it moves, a sharp one when it stands still. */
export function widthFor(sharp: number, load_s: number, moves: boolean): number {
  if (!moves || load_s < 0.2) return sharp;
  return Math.min(sharp, Math.max(240, Math.round(sharp / (load_s < 0.5 ? 2 : 4))));
}

/**
 * What comes next, to be there in time: places along `times`, nearest first. Playing goes on by what passes while one
 * image comes; while it stands still, its neighbours are what somebody steps to.
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

/** How far back an image may be that stands for the present one while the link is slow. */
const LEAST_BACK_S = 0.5;
/**
 * The image to show: the one of this moment if it is there; while playing else the newest before it that is, but not what
 * was seen long ago. -1: the last one stays.
 */
export function bestOf(times: readonly number[], position: number, speed: number, load_s: number, isPlaying: boolean, isThere: (i: number) => boolean): number {
  const here = indexAt(times, position);
  if (here < 0 || isThere(here)) return here;
  if (!isPlaying) return -1;
  const oldest = times[here]! - Math.max(LEAST_BACK_S, 3 * load_s) * Math.max(1, speed);
  for (let i = here - 1; i >= 0 && times[i]! >= oldest; i--) if (isThere(i)) return i;
  return -1;
}
