// SPDX-License-Identifier: Apache-2.0
// A clip that is played: which of its images is shown, and what all cameras saw then.
import { computed, onMounted, onUnmounted, ref, shallowRef, watch, type ShallowRef } from 'vue';
import { api, ApiError, messageOf } from '../../../api/client';
import type { ClipCamera, ClipFrame, ClipFrames } from '../../../api/types';
import { clipPath } from '../../../clips/paths';
import { inOrder, type TimedEvent } from '../timeline';
import { indexAt, useClock } from './clock';
import { ahead, bestOf, Loader, widthFor, type Want } from './loader';
import { LostRobots } from './lost';

/** Images as they came; decoded they would take fifty times as much. */
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
  /** Why there is nothing to play, or nothing new comes. */
  const trouble = ref('');
  const isGone = ref(false);
  const length = computed(() => Math.max(0.001, clip.value?.seconds ?? 0.001));
  const clock = useClock(() => length.value);
  const cameraId = ref(first);
  const camera = computed<ClipCamera | null>(() => clip.value?.cameras.find(({ id }) => id === cameraId.value) ?? clip.value?.cameras[0] ?? null);
  /** JPEG width that is as sharp as what is shown; 0: nothing is shown yet. */
  const sharp = ref(0);
  const isDragging = ref(false);

  const shown: ShallowRef<ShownFrame | null> = shallowRef(null);
  /** Grows with each answer, for what is computed from answers. */
  const version = ref(0);
  const lost = new Map<number, LostRobots>();
  /** Grows with news about lost robots. */
  const lostVersion = ref(0);
  /** Only the chosen camera's, as of the others not every frame is asked for. */
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

  /** What is wanted now, the most important first. */
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
    // What was made small for a slow link is asked for again when it stands still.
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
      // Nothing else is to be done: which robots vanish is found frame by frame.
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

  /** A frame's images are decoded one at a time; what has come meanwhile is looked at again. */
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
      // Only what came since is new; the service asks for few, so this stays short.
      for (const i of fresh(one)) if (known.take(i, loader.get<ClipFrame>(objectsKey(one.places[i]!))!)) isNews = true;
    }
    if (isNews) lostVersion.value++;
    version.value++;
    void show();
    plan();
  }
  /** Frames that were asked for and are there, but not looked at yet: near the position, and those one after the other. */
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

  /** Images a second that are really shown, for the last second of playing. */
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

  /** What each camera saw at the moment that is shown. */
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
    /** The image of the present moment is on its way. */
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
    /** To a frame of the chosen camera. */
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
