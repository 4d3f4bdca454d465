// SPDX-License-Identifier: Apache-2.0
// The playback position: seconds since the beginning, regardless of which images have arrived.
import { computed, onUnmounted, ref, watch } from 'vue';

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 16] as const;
export const speeds = SPEEDS.map((value) => ({ value, text: `${value}×` }));

/** After a longer step, such as in a hidden window, playback continues where it was. */
const LONGEST_STEP_S = 1;

/** The next position after `elapsed_s`, and whether the end is reached. */
export function advance(position: number, elapsed_s: number, speed: number, length: number): { position: number; isOver: boolean } {
  const step = elapsed_s > LONGEST_STEP_S ? 0 : Math.max(0, elapsed_s) * speed;
  const next = position + step;
  return next >= length ? { position: length, isOver: true } : { position: next, isOver: false };
}

/**
 * Index of the last time that is not after `time`; 0 if all are after it; -1 if there are none. `times` must be
 * ascending.
 */
export function indexAt(times: readonly number[], time: number): number {
  // The tolerance includes a frame whose time was rounded by a jump.
  const limit = time + 1e-6;
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= limit) low = middle + 1;
    else high = middle;
  }
  return times.length ? Math.max(0, low - 1) : -1;
}

/** The next time after `time`, or the previous one; null: there is none. */
export function neighbour(times: readonly number[], time: number, direction: 1 | -1): number | null {
  const beyond = times.filter((one) => (direction > 0 ? one > time + 1e-4 : one < time - 1e-4));
  if (!beyond.length) return null;
  return direction > 0 ? Math.min(...beyond) : Math.max(...beyond);
}

export function useClock(length: () => number) {
  const position = ref(0);
  const speed = ref<(typeof SPEEDS)[number]>(1);
  const isPlaying = ref(false);
  let last = 0;
  let frame = 0;

  function step(now: number): void {
    const next = advance(position.value, (now - last) / 1000, speed.value, length());
    last = now;
    position.value = next.position;
    if (next.isOver) isPlaying.value = false;
    frame = isPlaying.value ? requestAnimationFrame(step) : 0;
  }
  watch(isPlaying, (is) => {
    if (!is || frame) return;
    last = performance.now();
    frame = requestAnimationFrame(step);
  });
  onUnmounted(() => cancelAnimationFrame(frame));

  const isAtEnd = computed(() => position.value >= length());
  return {
    position, speed, isPlaying, isAtEnd,
    /** Plays or pauses; starts from the beginning if it was at the end. */
    toggle(): void {
      if (!isPlaying.value && isAtEnd.value) position.value = 0;
      isPlaying.value = !isPlaying.value;
    },
    /** `time` is clamped to the recording. */
    seek(time: number): void { position.value = Math.min(length(), Math.max(0, time)); },
  };
}
export type Clock = ReturnType<typeof useClock>;
