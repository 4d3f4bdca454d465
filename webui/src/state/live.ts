// SPDX-License-Identifier: Apache-2.0
// What the daemon said last, and whether that is still worth showing.
import { computed, ref, shallowRef } from 'vue';
import { api } from '../api/client';
import { PanelSocket } from '../api/socket';
import type { Detections, PreviewRequest, Status, Timeline } from '../api/types';
import type { PreviewMessage } from '../api/messages';
import { mergeBalls, mergeRobots, type SeenBall, type SeenRobot } from '../field/merge';
import { History, HISTORY_MS } from './history';

/** After this long without news nothing is shown as live any more. */
export const STALE_MS = 3000;
/** A camera's objects leave the field map after this long without news of that camera. */
const OBJECTS_MS = 1000;

const lastStatus = shallowRef<Status | null>(null);
const lastStatusAt = ref(performance.now());
export const now = ref(performance.now());
export const isOpen = ref(false);

export const silentSeconds = computed(() => Math.max(0, (now.value - lastStatusAt.value) / 1000));
export const isStale = computed(() => now.value - lastStatusAt.value >= STALE_MS);

/** The last status whatever its age: for names and shapes, never for live numbers. */
export const knownStatus = computed(() => lastStatus.value);
/** The status while it is fresh, else null. */
export const liveStatus = computed(() => (isStale.value ? null : lastStatus.value));

export type Connection = 'connecting' | 'live' | 'stale';
export const connection = computed<Connection>(() =>
  isStale.value ? 'stale' : lastStatus.value && isOpen.value ? 'live' : 'connecting');

export const history = new History();
/** Grows with every status, so that computed values built on the history follow it. */
export const historyVersion = ref(0);

export interface FieldObjects {
  robots: SeenRobot[];
  balls: SeenBall[];
}
export const fieldObjects = shallowRef<FieldObjects>({ robots: [], balls: [] });
/** The field's objects at the last status: for numbers, which nobody reads thirty times a second. */
export const steadyObjects = shallowRef<FieldObjects>(fieldObjects.value);

const detections = new Map<number, { data: Detections; at: number }>();
let redraw = false;

function gatherObjects(): void {
  redraw = false;
  const oldest = performance.now() - OBJECTS_MS;
  for (const [camera, { at }] of detections) if (at < oldest) detections.delete(camera);
  const all = [...detections.values()].map(({ data }) => data);
  fieldObjects.value = {
    robots: mergeRobots(all.flatMap(({ camera, robots }) => robots.map((robot) => ({ ...robot, camera })))),
    balls: mergeBalls(all.flatMap(({ camera, balls }) => balls.map((ball) => ({ ...ball, camera })))),
  };
}

const watchers = new Set<(data: Detections) => void>();

/** Calls with every image's detections, of all cameras. Returns how to stop that. */
export function watchDetections(watcher: (data: Detections) => void): () => void {
  watchers.add(watcher);
  return () => { watchers.delete(watcher); };
}

function onDetections(data: Detections): void {
  for (const watcher of watchers) watcher(data);
  detections.set(data.camera, { data, at: performance.now() });
  if (redraw) return;
  redraw = true;
  requestAnimationFrame(gatherObjects);
}

/**
 * The daemon's clock minus ours, at least: the fastest status of late tells it best.
 * What the network takes at its fastest cannot be told apart from a clock that is behind.
 */
const clockSamples: number[] = [];
const CLOCK_SAMPLES = 60;

/** The connection is new: what was measured before it is asked for once the clocks can be compared. */
let hasGap = false;

/** A graph that cannot be filled fills by itself: no reason to tell anybody. */
async function fillGap(daemonTime: number, at: number): Promise<void> {
  const timeline = await api.get<Timeline>(`timeline?seconds=${HISTORY_MS / 1000}`).catch(() => null);
  if (!timeline) return;
  history.fill(timeline, (time) => at + 1000 * (time - daemonTime));
  historyVersion.value++;
}

function onStatus(status: Status): void {
  const at = performance.now();
  clockSamples.push(status.time - Date.now() / 1000);
  if (clockSamples.length > CLOCK_SAMPLES) clockSamples.shift();
  history.record(status, at);
  historyVersion.value++;
  steadyObjects.value = fieldObjects.value;
  lastStatus.value = status;
  lastStatusAt.value = at;
  if (hasGap) void fillGap(status.time, at);
  hasGap = false;
}

/** Seconds since a moment on the daemon's clock. */
export function ageOf(daemonTime: number): number {
  if (!clockSamples.length) return 0;
  return Math.max(0, Date.now() / 1000 + Math.max(...clockSamples) - daemonTime);
}

export type PreviewListener = (message: PreviewMessage) => void;
const previews = new Map<number, { request: PreviewRequest; listener: PreviewListener }>();
let socket: PanelSocket | null = null;

/** Asks for a camera's images; asking again changes size and rate. Survives reconnects. */
export function startPreview(request: PreviewRequest, listener: PreviewListener): void {
  previews.set(request.camera, { request, listener });
  socket?.send({ preview: request });
}

export function stopPreview(camera: number, listener: PreviewListener): void {
  // Another view may have taken this camera over in the meantime.
  if (previews.get(camera)?.listener !== listener) return;
  previews.delete(camera);
  socket?.send({ stop_preview: camera });
}

export function acknowledge(camera: number, frame: number): void {
  socket?.send({ ack: { camera, frame } });
}

/** How a view gets a camera's images. */
export interface PictureLine {
  start: typeof startPreview;
  stop: typeof stopPreview;
  acknowledge: typeof acknowledge;
}
export const sharedLine: PictureLine = { start: startPreview, stop: stopPreview, acknowledge };

/** A connection of its own for a second image of the same camera: the shared one carries one of each. */
export function openLine(): PictureLine & { end(): void } {
  let wanted: { request: PreviewRequest; listener: PreviewListener } | null = null;
  const line = new PanelSocket(socketUrl(), {
    open() {
      // Without a word now and then a connection counts as dead.
      line.send({ subscribe: ['status'] });
      if (wanted) line.send({ preview: wanted.request });
    },
    text() {},
    preview(message) { wanted?.listener(message); },
    closed() {},
  });
  return {
    start(request, listener) {
      wanted = { request, listener };
      line.send({ preview: request });
    },
    stop(camera) {
      wanted = null;
      line.send({ stop_preview: camera });
    },
    acknowledge: (camera, frame) => line.send({ ack: { camera, frame } }),
    end: () => line.end(),
  };
}

function socketUrl(): string {
  const url = new URL('api/ws', document.baseURI);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  url.hash = '';
  return url.href;
}

export function connect(): void {
  socket = new PanelSocket(socketUrl(), {
    open() {
      isOpen.value = true;
      hasGap = true;
      socket!.send({ subscribe: ['status', 'detections'] });
      for (const { request } of previews.values()) socket!.send({ preview: request });
    },
    text(message) {
      if (message.kind === 'status') onStatus(message.data);
      else if (message.kind === 'detections') onDetections(message.data);
      else console.warn(`ssl-visiond: ${message.text}`);
    },
    preview(message) {
      previews.get(message.header.camera)?.listener(message);
    },
    closed() {
      isOpen.value = false;
    },
  });
  setInterval(() => {
    now.value = performance.now();
    if (detections.size) gatherObjects();
  }, 250);
}
