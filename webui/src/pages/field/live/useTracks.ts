// SPDX-License-Identifier: Apache-2.0
import { onMounted, onUnmounted, ref, shallowRef, type Ref, type ShallowRef } from 'vue';
import type { FieldTracks } from '../../../api/types';
import { ageOf, watchDetections, watchTracks } from '../../../state/live';
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
  /** Nothing has arrived yet, within the time allowed for it. */
  isWaiting: Readonly<Ref<boolean>>;
}

/** Follows the service's tracks while the page is visible. */
export function useTracks(): Tracks {
  const feed: TracksFeed = { tracks: null, trails: new Trails(), raw: new RawReports() };
  const steady = shallowRef<FieldTracks | null>(null);
  const age_s = ref<number | null>(null);
  const isWaiting = ref(true);
  let stops: (() => void)[] = [];
  let patience = 0;
  let beat = 0;

  function look(): void {
    steady.value = feed.tracks;
    age_s.value = feed.tracks && feed.tracks.number > 0 ? ageOf(feed.tracks.time) : null;
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
      watchDetections((detections) => feed.raw.take(detections, performance.now(), feed.tracks)),
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
  return { feed, steady, age_s, isWaiting };
}
