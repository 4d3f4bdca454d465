// SPDX-License-Identifier: Apache-2.0
// The daemon's last messages, and whether they are still live.
import { computed, onMounted, onUnmounted, ref, shallowReactive, shallowRef } from 'vue';
import { api } from '../api/client';
import { PanelSocket } from '../api/socket';
import type { Detections, FieldTracks, PacketTimeline, PreviewRequest, Status, Timeline } from '../api/types';
import type { PreviewMessage } from '../api/messages';
import { mergeBalls, mergeRobots, type SeenBall, type SeenRobot } from '../field/merge';
import { History, HISTORY_MS } from './history';
import { LinkMeter } from './linkMeter';

/** After this long without a status, nothing is shown as live. */
export const STALE_MS = 3000;
/** The same on a link that is known to be slow: without any message, and without a status. */
const SLOW_STALE_MS = 6000;
const SLOW_STATUS_MS = 12_000;
/** If the next status is this late, the link is slow or dead. */
const LATE_STATUS_MS = 1800;
/** A camera's objects are removed from the field map after this long without a message about that camera. */
const OBJECTS_MS = 1000;

const lastStatus = shallowRef<Status | null>(null);
const lastStatusAt = ref(performance.now());
export const now = ref(performance.now());
export const isOpen = ref(false);

export const silentSeconds = computed(() => Math.max(0, (now.value - lastStatusAt.value) / 1000));
const meter = new LinkMeter();
/** Whether statuses have arrived late so far. */
const areStatusesLate = ref(false);
/** Views for which even the smallest images arrive late or rarely. */
const starved = shallowReactive(new Set<object>());
const isKnownSlow = computed(() => areStatusesLate.value || starved.size > 0);
export function setStarved(view: object, is: boolean): void {
  if (is) starved.add(view);
  else starved.delete(view);
}
/** Time of the last message of any kind on the connection. */
const heardAt = ref(0);
export const isStale = computed(() => {
  const silentMs = now.value - lastStatusAt.value;
  if (!isOpen.value || !isKnownSlow.value) return silentMs >= STALE_MS;
  return now.value - heardAt.value >= SLOW_STALE_MS || silentMs >= SLOW_STATUS_MS;
});
/** Messages arrive late or rarely; silence is a different state. */
export const isLinkSlow = computed(() => !isStale.value && lastStatus.value !== null && isOpen.value && (isKnownSlow.value || now.value - lastStatusAt.value >= LATE_STATUS_MS));

/** The last status whatever its age: for names and shapes, never for live numbers. */
export const knownStatus = computed(() => lastStatus.value);
/** The status while it is fresh, else null. */
export const liveStatus = computed(() => (isStale.value ? null : lastStatus.value));

export type Connection = 'connecting' | 'live' | 'stale';
export const connection = computed<Connection>(() =>
  isStale.value ? 'stale' : lastStatus.value && isOpen.value ? 'live' : 'connecting');

/** Shown until the service has sent data. */
export const waitingText = computed(() => (isStale.value ? 'The service cannot be reached. The panel tries again automatically.' : 'Connecting to ssl-visiond…'));

export const history = new History();
/** Increases with every status, so that values computed from the history are updated. */
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

/**
 * Calls `watcher` with the detections of every image of all cameras. The service sends them only while somebody
 * watches, because they take most of a slow link. Returns a function that stops it.
 */
export function watchDetections(watcher: (data: Detections) => void): () => void {
  if (watchers.size === 0) socket?.send({ subscribe: ['detections'] });
  watchers.add(watcher);
  return () => {
    if (watchers.delete(watcher) && watchers.size === 0) socket?.send({ unsubscribe: ['detections'] });
  };
}

/** For a component that shows `fieldObjects` or `steadyObjects`: keeps them up to date while it is mounted. */
export function useFieldObjects(): void {
  let stop = () => {};
  onMounted(() => { stop = watchDetections(() => {}); });
  onUnmounted(() => stop());
}

function onDetections(data: Detections): void {
  for (const watcher of watchers) watcher(data);
  detections.set(data.camera, { data, at: performance.now() });
  if (redraw) return;
  redraw = true;
  requestAnimationFrame(gatherObjects);
}

const trackWatchers = new Set<(tracks: FieldTracks) => void>();

/**
 * Calls `watcher` with the tracks of all cameras, about thirty times a second; the service sends them only while
 * somebody watches. Returns a function that stops it.
 */
export function watchTracks(watcher: (tracks: FieldTracks) => void): () => void {
  if (trackWatchers.size === 0) socket?.send({ subscribe: ['field'] });
  trackWatchers.add(watcher);
  return () => {
    if (trackWatchers.delete(watcher) && trackWatchers.size === 0) socket?.send({ unsubscribe: ['field'] });
  };
}

/** For each camera: the number of images at the service when it last increased, and the uptime then. */
const growths = new Map<number, { frames: number; uptime_s: number }>();

/** The connection is new: earlier measurements are requested once the clocks can be compared. */
let hasGap = false;

/** On failure the graph fills up automatically, so nothing is reported. */
async function fillGap(daemonTime: number, at: number): Promise<void> {
  const seconds = HISTORY_MS / 1000;
  const localTime = (time: number) => at + 1000 * (time - daemonTime);
  const [timeline, packets] = await Promise.all([
    api.get<Timeline>(`timeline?seconds=${seconds}`).catch(() => null),
    api.get<PacketTimeline>(`network/timeline?seconds=${seconds}`).catch(() => null),
  ]);
  if (timeline) history.fill(timeline, localTime);
  if (packets) history.fillPackets(packets, localTime);
  historyVersion.value++;
}

function onStatus(status: Status): void {
  const at = performance.now();
  meter.heard(status.uptime_s * 1000, at);
  areStatusesLate.value = meter.isSlow;
  for (const { id, frames } of status.cameras)
    if (growths.get(id)?.frames !== frames) growths.set(id, { frames, uptime_s: status.uptime_s });
  history.record(status, at);
  historyVersion.value++;
  steadyObjects.value = fieldObjects.value;
  lastStatus.value = status;
  lastStatusAt.value = at;
  if (hasGap) void fillGap(status.time, at);
  hasGap = false;
}

/**
 * Minimum time since a moment on the service's clock, s: the current time there is estimated from the fastest recent
 * status. The network's minimum delay cannot be distinguished from a clock that is behind.
 */
export function ageOf(daemonTime: number): number {
  const uptimeMs = meter.uptimeMs(performance.now());
  const status = lastStatus.value;
  if (uptimeMs === null || !status) return 0;
  return Math.max(0, status.time - status.uptime_s + uptimeMs / 1000 - daemonTime);
}

/** Seconds in which the service itself received no new image from a camera, at its last status. */
export function imageGapAtService(camera: number): number {
  return Math.max(0, (lastStatus.value?.uptime_s ?? 0) - (growths.get(camera)?.uptime_s ?? 0));
}

export type PreviewListener = (message: PreviewMessage) => void;
const previews = new Map<number, { request: PreviewRequest; listener: PreviewListener }>();
let socket: PanelSocket | null = null;

/** Requests a camera's images; a second call changes size and rate. Survives reconnects. */
export function startPreview(request: PreviewRequest, listener: PreviewListener): void {
  previews.set(request.camera, { request, listener });
  socket?.send({ preview: request });
}

export function stopPreview(camera: number, listener: PreviewListener): void {
  // Another view may have taken over this camera meanwhile.
  if (previews.get(camera)?.listener !== listener) return;
  previews.delete(camera);
  socket?.send({ stop_preview: camera });
}

export function acknowledge(camera: number, frame: number): void {
  socket?.send({ ack: { camera, frame } });
}

/** The connection through which a view receives a camera's images. */
export interface PictureLine {
  start: typeof startPreview;
  stop: typeof stopPreview;
  acknowledge: typeof acknowledge;
}
export const sharedLine: PictureLine = { start: startPreview, stop: stopPreview, acknowledge };

/** A separate connection for a second image of the same camera: the shared one carries only one of each camera. */
export function openLine(): PictureLine & { end(): void } {
  let wanted: { request: PreviewRequest; listener: PreviewListener } | null = null;
  const line = new PanelSocket(`${socketUrl()}?second`, {
    open() {
      // A connection without regular messages counts as dead, so it subscribes to the status.
      line.send({ subscribe: ['status'] });
      if (wanted) line.send({ preview: wanted.request });
    },
    text() {},
    preview(message) { wanted?.listener(message); },
    closed() {},
  }, () => isKnownSlow.value);
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
      meter.opened();
      socket!.send({ subscribe: ['status', ...(watchers.size ? ['detections' as const] : []), ...(trackWatchers.size ? ['field' as const] : [])] });
      for (const { request } of previews.values()) socket!.send({ preview: request });
    },
    text(message) {
      if (message.kind === 'status') onStatus(message.data);
      else if (message.kind === 'detections') onDetections(message.data);
      else if (message.kind === 'field') for (const watcher of trackWatchers) watcher(message.data);
      else console.warn(`ssl-visiond: ${message.text}`);
    },
    preview(message) {
      previews.get(message.header.camera)?.listener(message);
    },
    closed() {
      isOpen.value = false;
    },
  }, () => isKnownSlow.value);
  setInterval(() => {
    now.value = performance.now();
    heardAt.value = socket!.heardAt;
    if (detections.size) gatherObjects();
  }, 250);
}
