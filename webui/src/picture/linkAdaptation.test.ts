// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { adapt, EFFORTS, isStarved, LINK_START, type LinkPeriod, type LinkState } from './linkAdaptation';

const fine: LinkPeriod = { delayMs: 20, fps: 29, wantedFps: 30 };
const after = (state: LinkState, ...periods: LinkPeriod[]) => periods.reduce(adapt, state);
const times = (count: number, period: LinkPeriod) => Array<LinkPeriod>(count).fill(period);

describe('adaptation to the link', () => {
  it('leaves a good link alone', () => {
    expect(after(LINK_START, ...times(100, fine)).effort).toBe(0);
  });

  it('takes smaller images when they come late, and no smaller than the least', () => {
    const late = (delayMs: number) => ({ ...fine, delayMs });
    expect(after(LINK_START, fine, late(130)).effort).toBe(1);
    expect(after(LINK_START, fine, late(500), late(300), late(200)).effort).toBe(3);
    expect(after(LINK_START, fine, late(1500)).effort).toBe(EFFORTS.length - 1);
    expect(after(LINK_START, fine, ...times(300, late(9999))).effort).toBe(EFFORTS.length - 1);
  });

  it('says when even the smallest images do not do', () => {
    const few = { ...fine, fps: 5 };
    expect(isStarved(LINK_START, few)).toBe(false);
    const smallest = { ...LINK_START, effort: EFFORTS.length - 1, floorMs: 20 };
    expect(isStarved(smallest, few)).toBe(true);
    expect(isStarved(smallest, { ...fine, delayMs: 400 })).toBe(true);
    expect(isStarved(smallest, fine)).toBe(false);
  });

  it('takes no smaller ones for a while where that does not help', () => {
    const slow = { delayMs: 20, fps: 10, wantedFps: 30 };
    expect(after(LINK_START, ...times(20, slow)).effort).toBe(1);
    expect(after(LINK_START, ...times(25, slow)).effort).toBe(2);
    expect(after(LINK_START, slow, { ...slow, fps: 15 }).effort).toBe(2);
  });

  it('takes smaller images when few of those wanted come', () => {
    expect(after(LINK_START, { ...fine, fps: 12 }).effort).toBe(1);
    expect(after(LINK_START, { delayMs: 20, fps: 12, wantedFps: 15 }).effort).toBe(0);
  });

  it('measures the delay from what the link takes at best', () => {
    const far = { ...fine, delayMs: 400 };
    expect(after(LINK_START, ...times(20, far)).effort).toBe(0);
  });

  it('forgets a floor that was too low', () => {
    const state = after(LINK_START, { ...fine, delayMs: -200 }, ...times(400, fine));
    expect(state.floorMs).toBe(20);
    expect(state.effort).toBe(0);
  });

  it('takes better images again when there is room', () => {
    const low = { ...LINK_START, effort: 3, floorMs: 20 };
    expect(after(low, ...times(3, fine)).effort).toBe(3);
    expect(after(low, ...times(4, fine)).effort).toBe(2);
    expect(after(low, ...times(12, fine)).effort).toBe(0);
  });

  it('neither raises nor lowers in between', () => {
    expect(after({ ...LINK_START, effort: 2, floorMs: 20 }, ...times(20, { ...fine, delayMs: 75, fps: 26 })).effort).toBeLessThanOrEqual(2);
    expect(after({ ...LINK_START, effort: 2, floorMs: 20 }, ...times(20, { ...fine, fps: 21 })).effort).toBe(2);
  });

  it('tries ever more seldom what failed before', () => {
    const late = { ...fine, delayMs: 150 };
    const low = { ...LINK_START, effort: 3, floorMs: 20 };
    const failed = after(low, ...times(4, fine), late);
    expect(failed).toMatchObject({ effort: 3, patience: 8 });
    expect(after(failed, ...times(7, fine)).effort).toBe(3);
    expect(after(failed, ...times(8, fine)).effort).toBe(2);
  });
});
