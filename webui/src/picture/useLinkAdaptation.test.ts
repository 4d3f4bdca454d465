// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { effectScope, nextTick, ref, type EffectScope } from 'vue';
import { useLinkAdaptation } from './useLinkAdaptation';
import type { Shown } from './useLivePicture';

const starved = vi.hoisted(() => new Set<object>());
vi.mock('../state/live', () => ({
  isLinkSlow: { value: true }, // starts with the smallest images
  setStarved: (view: object, is: boolean) => { if (is) starved.add(view); else starved.delete(view); },
}));

let scope: EffectScope;
const areDue = ref(true);
let count: (shown: Shown) => void;
/** Five seconds with one image a second, while fifteen are requested. */
const starve = () => { for (let i = 0; i < 5; i++) count({ at: i * 1000, delayMs: 900 } as Shown); };

beforeEach(() => {
  vi.useFakeTimers();
  areDue.value = true;
  scope = effectScope();
  scope.run(() => { ({ count } = useLinkAdaptation(() => 15, () => areDue.value)); });
  starve();
  expect(starved.size).toBe(1);
});
afterEach(() => {
  scope.stop();
  vi.useRealTimers();
});

describe('a slow link', () => {
  it('is no longer told when the camera is lost or the view frozen, whatever comes late', async () => {
    areDue.value = false;
    await nextTick();
    expect(starved.size).toBe(0);
    starve();
    expect(starved.size).toBe(0);
  });

  it('is no longer told when no more images come', () => {
    vi.advanceTimersByTime(9000);
    expect(starved.size).toBe(1);
    vi.advanceTimersByTime(2000);
    expect(starved.size).toBe(0);
  });

  it('is no longer told when the view is gone', () => {
    scope.stop();
    expect(starved.size).toBe(0);
  });
});
