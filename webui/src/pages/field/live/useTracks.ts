// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted, ref, shallowRef, watch, type Ref, type ShallowRef } from 'vue';
import type { FieldTracks } from '../../../api/types';
import { ageOf, knownStatus, watchDetections, watchTracks } from '../../../state/live';
import { layer } from './layers';
import { RawReports } from './raw';
import { Trails } from './trails';

/** The newest messages. Nothing here is reactive: it is drawn sixty times a second. */
export interface TracksFeed {
  tracks: FieldTracks | null;
  readonly trails: Trails;
  readonly raw: RawReports;
}

/** Numbers that change faster cannot be read. */
const STEADY_MS = 500;
/** Time allowed for the first message before something is reported missing. */
const PATIENCE_MS = 1500;

export interface Tracks {
  feed: TracksFeed;
  /** The tracks for numbers; null before the first. */
  steady: Readonly<ShallowRef<FieldTracks | null>>;
  /** Age on the service's clock; null before anything was tracked. */
  age_s: Readonly<Ref<number | null>>;
  /** The same compared with the newest status, which comes over the same link: not older on a slow one. */
  lag_s: Readonly<Ref<number | null>>;
  /** Nothing has arrived yet, within the time allowed for it. */
  isWaiting: Readonly<Ref<boolean>>;
}

/** Follows the service's tracks while the page is visible. */
export function useTracks(): Tracks {
  const feed: TracksFeed = { tracks: null, trails: new Trails(), raw: new RawReports() };
  const steady = shallowRef<FieldTracks | null>(null);
  const age_s = ref<number | null>(null);
  const lag_s = ref<number | null>(null);
  const isWaiting = ref(true);
  let stops: (() => void)[] = [];
  let patience = 0;
  let beat = 0;

  function look(): void {
    steady.value = feed.tracks;
    const time = feed.tracks && feed.tracks.number > 0 ? feed.tracks.time : null;
    age_s.value = time === null ? null : ageOf(time);
    lag_s.value = time === null ? null : Math.max(0, (knownStatus.value?.time ?? time) - time);
  }
  function stop(): void {
    for (const end of stops) end();
    stops = [];
    clearTimeout(patience);
    clearInterval(beat);
  }
  function start(): void {
    stop();
    // Data from before the page was hidden are outdated.
    feed.tracks = null;
    feed.trails.clear();
    feed.raw.clear();
    isWaiting.value = true;
    patience = window.setTimeout(() => { isWaiting.value = false; }, PATIENCE_MS);
    beat = window.setInterval(look, STEADY_MS);
    stops = [
      watchTracks((tracks) => {
        feed.tracks = tracks;
        if (tracks.number > 0) feed.trails.add(tracks);
        if (!isWaiting.value) return;
        isWaiting.value = false;
        look();
      }),
      watch(layer, (shown, _before, onCleanup) => {
        if (shown !== 'raw') return;
        feed.raw.clear();
        onCleanup(watchDetections((detections) => feed.raw.take(detections, performance.now(), feed.tracks)));
      }, { immediate: true }),
    ];
  }
  const onVisibility = () => (document.hidden ? stop() : start());

  onMounted(() => {
    onVisibility();
    document.addEventListener('visibilitychange', onVisibility);
  });
  onUnmounted(() => {
    document.removeEventListener('visibilitychange', onVisibility);
    stop();
  });
  return { feed, steady, age_s, lag_s, isWaiting };
}
