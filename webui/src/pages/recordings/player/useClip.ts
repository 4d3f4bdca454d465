// SPDX-License-Identifier: Apache-2.0
// Playback of a clip: which image is shown, and what all cameras saw at that moment.
import { computed, onMounted, onUnmounted, ref, shallowRef, watch, type ShallowRef } from 'vue';
import { api, ApiError, messageOf } from '../../../api/client';
import type { ClipCamera, ClipFrame, ClipFrames } from '../../../api/types';
import { clipPath } from '../../../clips/paths';
import { inOrder, type TimedEvent } from '../timeline';
import { indexAt, useClock } from './clock';
import { ahead, bestOf, Loader, widthFor, type Want } from './loader';
import { LostRobots } from './lost';

/** Images are kept as JPEG: decoded they would need fifty times the memory. */
const LIMITS = { image: 300, objects: 4000 };
const RETRY_MS = 2000;
const RATE_MS = 1000;

interface Jpeg { blob: Blob; width: number }
export interface ShownFrame {
  place: number;
  index: number;
  frame: ClipFrame;
  picture: ImageBitmap;
}

export function useClip(name: string, first: number | null) {
  const path = clipPath(name);
  const clip = shallowRef<ClipFrames | null>(null);
  /** Why nothing can be played, or nothing new arrives. */
  const trouble = ref('');
  const isGone = ref(false);
  const length = computed(() => Math.max(0.001, clip.value?.seconds ?? 0.001));
  const clock = useClock(() => length.value);
  const cameraId = ref(first);
  const camera = computed<ClipCamera | null>(() => clip.value?.cameras.find(({ id }) => id === cameraId.value) ?? clip.value?.cameras[0] ?? null);
  /** JPEG width that is sharp at the displayed size; 0: nothing is displayed yet. */
  const sharp = ref(0);
  const isDragging = ref(false);

  const shown: ShallowRef<ShownFrame | null> = shallowRef(null);
  /** Increases with each answer, for values computed from answers. */
  const version = ref(0);
  const lost = new Map<number, LostRobots>();
  /** Increases when lost robots are found. */
  const lostVersion = ref(0);
  /** Only for the selected camera, because not every frame of the others is requested. */
  const lostEvents = computed<TimedEvent[]>(() => {
    void lostVersion.value;
    return camera.value ? lost.get(camera.value.id)?.events ?? [] : [];
  });
  let alive = true;

  const loader = new Loader(LIMITS, onAnswer, onFailure);
  const imageKey = (place: number) => `image ${place}`;
  const objectsKey = (place: number) => `objects ${place}`;
  const wantImage = (place: number, width: number): Want<Jpeg> => ({
    key: imageKey(place), kind: 'image', ask: async () => ({ blob: await api.blob(`${path}/frames/${place}/picture?width=${width}`), width }),
  });
  const wantObjects = (place: number): Want<ClipFrame> => ({ key: objectsKey(place), kind: 'objects', ask: () => api.get<ClipFrame>(`${path}/frames/${place}`) });
  const isThere = (one: ClipCamera) => (i: number) => loader.has(imageKey(one.places[i]!)) && loader.has(objectsKey(one.places[i]!));

  /** Requests what is wanted now, the most important first. */
  function plan(): void {
    const [all, mine] = [clip.value, camera.value];
    if (!all || !mine || !mine.places.length || !sharp.value || !alive) return;
    const [position, speed, isPlaying] = [clock.position.value, clock.speed.value, clock.isPlaying.value];
    const width = widthFor(sharp.value, loader.seconds, isPlaying || isDragging.value);
    const here = indexAt(mine.times_s, position);
    const wants: Want<unknown>[] = [];
    const add = (i: number) => wants.push(wantObjects(mine.places[i]!), wantImage(mine.places[i]!, width));
    const addOthers = (time: number) => {
      for (const other of all.cameras) {
        const i = indexAt(other.times_s, time);
        if (other !== mine && i >= 0) wants.push(wantObjects(other.places[i]!));
      }
    };
    // When paused, an image that was loaded small for a slow link is requested again at full sharpness.
    const place = mine.places[here]!;
    const kept = loader.get<Jpeg>(imageKey(place));
    if (kept && !isPlaying && !isDragging.value && kept.width < width) wants.push({ ...wantImage(place, width), key: `${imageKey(place)} sharp` });
    add(here);
    addOthers(mine.times_s[here]!);
    if (!isDragging.value) {
      for (const i of ahead(mine.times_s, position, speed, 2 * loader.seconds, isPlaying)) {
        add(i);
        addOthers(mine.times_s[i]!);
      }
      // Nothing else to load: searches for lost robots frame by frame.
      const known = lost.get(mine.id);
      for (let k = 0; k < mine.places.length; k++) {
        const i = (here + k) % mine.places.length;
        if (known?.knows(i)) continue;
        wants.push(wantObjects(mine.places[i]!));
        break;
      }
    }
    loader.want(wants);
  }

  /** Images are decoded one at a time; after each one, show() checks for a newer one. */
  let isDecoding = false;
  async function show(): Promise<void> {
    const mine = camera.value;
    if (!mine || isDecoding || !alive) return;
    const i = bestOf(mine.times_s, clock.position.value, clock.speed.value, loader.seconds, clock.isPlaying.value || isDragging.value, isThere(mine));
    if (i < 0) return;
    const place = mine.places[i]!;
    const jpeg = loader.get<Jpeg>(`${imageKey(place)} sharp`) ?? loader.get<Jpeg>(imageKey(place))!;
    if (shown.value?.place === place && drawnWidth >= jpeg.width) return;
    const frame = loader.get<ClipFrame>(objectsKey(place))!;
    isDecoding = true;
    const picture = await createImageBitmap(jpeg.blob).catch(() => null);
    isDecoding = false;
    if (!alive || !picture || camera.value !== mine) { picture?.close(); if (alive && picture) void show(); return; }
    if (shown.value?.place !== place) moments.push(performance.now());
    const old = shown.value?.picture;
    drawnWidth = jpeg.width;
    shown.value = { place, index: i, frame, picture };
    old?.close();
    void show();
  }
  let drawnWidth = 0;

  function onAnswer(): void {
    trouble.value = '';
    let isNews = false;
    for (const one of clip.value?.cameras ?? []) {
      let known = lost.get(one.id);
      if (!known) lost.set(one.id, known = new LostRobots());
      // Only frames that arrived since are processed; few are requested at a time, so this stays short.
      for (const i of fresh(one)) if (known.take(i, loader.get<ClipFrame>(objectsKey(one.places[i]!))!)) isNews = true;
    }
    if (isNews) lostVersion.value++;
    version.value++;
    void show();
    plan();
  }
  /** Indices of frames that are loaded but not processed yet. */
  function fresh(one: ClipCamera): number[] {
    const known = lost.get(one.id)!;
    const out: number[] = [];
    for (let i = 0; i < one.places.length; i++) if (!known.knows(i) && loader.has(objectsKey(one.places[i]!))) out.push(i);
    return out;
  }

  async function onFailure(error: unknown): Promise<void> {
    trouble.value = messageOf(error);
    if (error instanceof ApiError && error.status === 404) await load();
  }

  async function load(): Promise<void> {
    try {
      const answer = await api.get<ClipFrames>(`${path}/frames`);
      if (!alive) return;
      clip.value ??= answer;
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

  watch([clock.position, camera, sharp, clock.isPlaying, isDragging], () => {
    plan();
    void show();
  });
  watch(camera, (now, before) => {
    if (now?.id === before?.id) return;
    drawnWidth = 0;
    shown.value?.picture.close();
    shown.value = null;
  }, { flush: 'sync' });

  /** Images per second that are really shown, over the last second of playing. */
  const rate = ref(0);
  let moments: number[] = [];
  let timer = 0;
  let retry = 0;
  onMounted(() => {
    void load();
    timer = window.setInterval(() => {
      const oldest = performance.now() - RATE_MS;
      moments = moments.filter((at) => at > oldest);
      rate.value = moments.length / (RATE_MS / 1000);
    }, RATE_MS / 2);
    retry = window.setInterval(() => {
      if (!isGone.value) void (clip.value ? plan() : load());
    }, RETRY_MS);
  });
  onUnmounted(() => {
    alive = false;
    loader.end();
    clearInterval(timer);
    clearInterval(retry);
    shown.value?.picture.close();
  });

  /** What each camera saw at the moment shown. */
  const seen = computed<ClipFrame[]>(() => {
    void version.value;
    const [all, now] = [clip.value, shown.value];
    if (!all || !now) return [];
    return all.cameras.flatMap((one) => {
      if (one.id === now.frame.camera) return [now.frame];
      const i = indexAt(one.times_s, now.frame.time_s);
      const frame = i < 0 ? undefined : loader.get<ClipFrame>(objectsKey(one.places[i]!));
      return frame ? [frame] : [];
    });
  });

  const ownEvents = computed<TimedEvent[]>(() => inOrder(clip.value?.events ?? []));
  return {
    clip, camera, cameraId, trouble, isGone, length, clock, shown, seen, sharp, isDragging, rate, lostEvents, ownEvents,
    /** The image of the current position is still loading. */
    isLate: computed(() => {
      const one = camera.value;
      return one !== null && !clock.isPlaying.value && shown.value?.index !== indexAt(one.times_s, clock.position.value);
    }),
    step(by: 1 | -1): void {
      const one = camera.value;
      if (!one?.places.length) return;
      clock.isPlaying.value = false;
      const here = indexAt(one.times_s, clock.position.value);
      clock.seek(one.times_s[Math.min(one.places.length - 1, Math.max(0, here + by))]!);
    },
    /** Seeks to a frame of the selected camera. */
    goTo(place: number): void {
      const one = camera.value;
      const i = one?.places.indexOf(place) ?? -1;
      if (!one || i < 0) return;
      clock.isPlaying.value = false;
      clock.seek(one.times_s[i]!);
    },
  };
}
export type PlayedClip = ReturnType<typeof useClip>;
