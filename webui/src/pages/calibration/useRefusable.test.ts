// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it, vi } from 'vitest';
import { ApiError } from '../../api/client';
import { useRefusable } from './useRefusable';

const refusing = (status: number) => vi.fn((force: boolean) => (force ? Promise.resolve() : Promise.reject(new ApiError(status, 'no'))));

describe('what may be refused', () => {
  it('says why and can be forced while the game runs', async () => {
    const { refusal, attempt } = useRefusable();
    const act = refusing(423);
    expect(await attempt('All the same', act)).toBe(false);
    expect(refusal.value).toMatchObject({ text: 'no', title: 'All the same' });
    await refusal.value!.force!();
    expect(act.mock.calls).toEqual([[false], [true]]);
    expect(refusal.value).toBeNull();
  });

  it('is not forced where that would not help', async () => {
    for (const status of [409, 422, 500]) {
      const { refusal, attempt } = useRefusable();
      await attempt('', refusing(status));
      expect(refusal.value?.force).toBeNull();
    }
    const { refusal, attempt } = useRefusable();
    await attempt('', refusing(409), () => true);
    expect(refusal.value?.force).not.toBeNull();
  });

  it('does not offer again what did not help', async () => {
    const { refusal, attempt, busy } = useRefusable();
    await attempt('', () => Promise.reject(new ApiError(423, 'no')));
    await refusal.value!.force!();
    expect(refusal.value?.force).toBeNull();
    expect(busy.value).toBe(false);
  });
});
