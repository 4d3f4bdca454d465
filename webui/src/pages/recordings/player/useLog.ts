// SPDX-License-Identifier: Apache-2.0
// Playback of a match log: the known state at each moment.
import { computed, onMounted, onUnmounted, ref, shallowRef, watch } from 'vue';
import { api, ApiError, messageOf } from '../../../api/client';
import type { LogMoment, MatchLogEvents } from '../../../api/types';
import { inOrder, lengthOf } from '../timeline';
import { logPath } from '../useRecordings';
import { indexAt, useClock } from './clock';
import { bestOf, Loader, type Want } from './loader';

const LIMITS = { moment: 300 };
/** Spacing of the requested moments: about the cameras' rate; fixed, so that playing again requests the same moments. */
export const STEP_S = 0.04;
const RETRY_MS = 2000;

export function useLog(name: string) {
  const path = logPath(name);
  const events = shallowRef<MatchLogEvents | null>(null);
  const trouble = ref('');
  const isGone = ref(false);
  const length = computed(() => (events.value ? lengthOf(events.value) : 1));
  const clock = useClock(() => length.value);
  const moment = shallowRef<LogMoment | null>(null);
  let alive = true;

  const loader = new Loader(LIMITS, onAnswer, (error) => {
    trouble.value = messageOf(error);
    if (error instanceof ApiError && error.status === 404) void load();
  });
  const tickOf = (time: number) => Math.floor(time / STEP_S + 1e-6);
  const keyOf = (tick: number) => `at ${tick}`;
  const want = (tick: number): Want<LogMoment> => ({ key: keyOf(tick), kind: 'moment', ask: () => api.get<LogMoment>(`${path}/at?time_s=${(tick * STEP_S).toFixed(3)}`) });

  function plan(): void {
    if (!events.value || !alive) return;
    const here = tickOf(clock.position.value);
    const wants = [want(here)];
    if (clock.isPlaying.value) {
      for (let k = 1; k <= 4; k++) wants.push(want(Math.max(tickOf(clock.position.value + k * clock.speed.value * loader.seconds), here + k)));
    } else wants.push(want(here + 1), want(Math.max(0, here - 1)));
    const last = tickOf(length.value);
    loader.want(wants.filter(({ key }) => Number(key.slice(3)) <= last));
    show();
  }
  function show(): void {
    const here = tickOf(clock.position.value);
    // The current tick and the earlier ticks that may replace it.
    const first = Math.max(0, here - 200);
    const ticks = Array.from({ length: here - first + 1 }, (_, i) => first + i);
    const i = bestOf(ticks.map((tick) => tick * STEP_S), here * STEP_S, clock.speed.value, loader.seconds, clock.isPlaying.value, (k) => loader.has(keyOf(ticks[k]!)));
    if (i >= 0) moment.value = loader.get<LogMoment>(keyOf(ticks[i]!)) ?? moment.value;
  }
  function onAnswer(): void {
    trouble.value = '';
    plan();
  }

  async function load(): Promise<void> {
    try {
      const answer = await api.get<MatchLogEvents>(`${path}/events`);
      if (!alive) return;
      events.value ??= answer;
      trouble.value = '';
      plan();
    } catch (error) {
      if (!alive) return;
      trouble.value = messageOf(error);
      if (error instanceof ApiError && error.status === 404) {
        isGone.value = true;
        clock.isPlaying.value = false;
        loader.end();
      }
    }
  }
  watch([clock.position, clock.isPlaying], plan);

  let retry = 0;
  onMounted(() => {
    void load();
    retry = window.setInterval(() => { if (!isGone.value) void (events.value ? plan() : load()); }, RETRY_MS);
  });
  onUnmounted(() => {
    alive = false;
    loader.end();
    clearInterval(retry);
  });

  const ordered = computed(() => inOrder(events.value?.events ?? []));
  return {
    events, ordered, trouble, isGone, length, clock, moment,
    step(by: 1 | -1): void {
      clock.isPlaying.value = false;
      clock.seek((tickOf(clock.position.value) + by) * STEP_S);
    },
    /** Index of the last event before the current position; -1: none. */
    current: computed(() => {
      const times = ordered.value.map(({ time_s }) => time_s);
      const i = indexAt(times, clock.position.value);
      return i >= 0 && times[i]! <= clock.position.value + 1e-6 ? i : -1;
    }),
  };
}
