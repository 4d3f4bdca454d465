// SPDX-License-Identifier: Apache-2.0
// Compares the packets and tracks of a service with those of an identical one that is not attacked. Both draw the same
// scene at the same moments, so their cameras' detections are equal byte by byte, except for the time of sending.
import { detectionOf, fieldsOf } from '../e2e/protobuf.mjs';
import { listenTo } from '../e2e/service.mjs';

const OWN_ADDRESS = '127.0.0.1'; // strangers have other addresses
const KEPT_S = 5;
const MOST_APART_S = 0.02; // maximum time difference of tracks that are compared
const NEWEST = 100; // track packets kept for comparison
const MOST_OFF_MM = 1, LEAST_COMPARED = 0.95, MOST_SILENT_MS = 1000;
const COMPARED_CAMERAS = 2, GIGE_CAMERA = 2; // only the attacked service has the GigE camera
const CAPTURE = 2, SENT = 3, CAMERA = 4, BALLS = 5, YELLOW = 6, BLUE = 7;
const TRACKED = 3;

/** A camera's detections in an image: {camera, sent, key: which image, body}; null for other packets. */
function sightingsOf(packet) {
  const frame = fieldsOf(packet)[1]?.[0];
  if (!frame) return null;
  const f = fieldsOf(frame);
  const body = Buffer.concat([BALLS, YELLOW, BLUE].flatMap((number) => [Buffer.from([number]), ...(f[number] ?? [])]));
  return { camera: f[CAMERA][0], sent: f[SENT][0].readDoubleLE(0), key: `${f[CAMERA][0]} ${f[CAPTURE][0].toString('hex')}`, body: body.toString('base64') };
}

const floats = (bytes) => Object.values(fieldsOf(bytes)).map(([one]) => one.readFloatLE(0) * 1000);
/** {number, time, things: Map name -> {at, velocity}} in mm and s; null if it contains no tracks. */
function tracksOf(packet) {
  const outer = fieldsOf(packet);
  if (!outer[TRACKED]) return null;
  const f = fieldsOf(outer[TRACKED][0]);
  const things = new Map();
  // A second ball or a second robot with the same id gets another name.
  const add = (name, at, velocity) => things.set(things.has(name) ? `${name} again` : name, {
    at: floats(at).slice(0, 2), velocity: velocity ? floats(velocity[0]).slice(0, 2) : [0, 0],
  });
  for (const bytes of f[4] ?? []) {
    const { 1: [id], 2: [at], 4: velocity } = fieldsOf(bytes);
    const { 1: [number], 2: [team] } = fieldsOf(id);
    add(`${team === 1 ? 'yellow' : 'blue'} ${number}`, at, velocity);
  }
  for (const bytes of f[3] ?? []) {
    const { 1: [at], 2: velocity } = fieldsOf(bytes);
    add('ball', at, velocity);
  }
  return { number: f[1][0], time: f[2][0].readDoubleLE(0), things };
}

const OTHER = { attacked: 'control', control: 'attacked' };

/** Counts how the packets of 'attacked' differ from those of 'control'. `alone`: robots that only the attacked
 * service sees. */
export class Comparison {
  #alone;
  #images = { attacked: new Map(), control: new Map() };
  #newest = { attacked: [], control: [] }; // track packets
  #waiting; // track packets that wait for one of the same time or later from the other service
  #lastSent; // {time_s, number} of the attacked service, by kind of packet
  #figures;

  constructor(alone = []) {
    this.#alone = new Set(alone);
    this.begin();
  }

  /** Restarts the comparison. */
  begin(now_ms = Date.now()) {
    this.#waiting = { attacked: [], control: [] };
    this.#lastSent = new Map(['tracks', ...Array(COMPARED_CAMERAS).keys()].map((what) => [what, { time_s: now_ms / 1000 }]));
    this.#figures = {
      frames: { attacked: 0, control: 0 }, compared: 0, different: 0, tracks: 0, skippedTracks: 0, off: [], notFinite: 0, lost: 0, ghosts: new Map(), silent_ms: 0,
    };
  }

  end(now_ms = Date.now()) {
    for (const what of this.#lastSent.keys()) this.#hasSent(what, { time_s: now_ms / 1000 });
    const { off, frames, compared, tracks, skippedTracks, ...others } = this.#figures;
    const unanswered = this.#waiting.control.length;
    const sorted = [...off].sort((a, b) => a - b);
    const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(sorted.length * share))] ?? NaN;
    return {
      ...others, compared, share: compared / Math.max(1, frames.attacked, frames.control),
      tracksShare: (tracks - skippedTracks) / Math.max(1, tracks + unanswered), p99_mm: at(0.99), max_mm: at(1),
    };
  }

  /** Adds a packet with a camera's detections. */
  hear(who, packet, now_ms = Date.now()) {
    const sightings = sightingsOf(packet);
    if (!sightings) return;
    const { camera, sent, key, body } = sightings;
    if (camera > GIGE_CAMERA) this.#isGhost(`camera ${camera}`);
    if (camera >= COMPARED_CAMERAS) return;
    if (who === 'attacked') this.#hasSent(camera, { time_s: sent });
    this.#figures.frames[who]++;
    const others = this.#images[OTHER[who]];
    const theirs = others.get(key);
    if (theirs === undefined) return void this.#images[who].set(key, { body, at: now_ms });
    others.delete(key);
    this.#figures.compared++;
    if (theirs.body !== body) this.#figures.different++;
  }

  /** Adds a track packet. `wasDropped`: whether packets of that group were recently dropped before this program read
   * them. */
  follow(who, packet, wasDropped = () => false) {
    const tracks = tracksOf(packet);
    if (!tracks) return;
    if (who === 'attacked') {
      this.#hasSent('tracks', { time_s: tracks.time, number: tracks.number }, wasDropped);
      const isFinite = [tracks.time, ...[...tracks.things.values()].flatMap(({ at }) => at)].every(Number.isFinite);
      if (!isFinite) this.#figures.notFinite++;
    }
    if (!Number.isFinite(tracks.time)) return;
    this.#newest[who] = [...this.#newest[who].slice(1 - NEWEST), tracks];
    this.#waiting[who].push(tracks);
    for (const one of ['attacked', 'control']) {
      const waiting = this.#waiting[one], theirs = this.#newest[OTHER[one]];
      while (waiting.length > 0 && theirs.at(-1)?.time >= waiting[0].time) this.#compareTracks(one, waiting.shift(), theirs);
    }
  }

  /** Gives up on images that the other service has not sent. */
  forget(now_ms = Date.now()) {
    for (const known of Object.values(this.#images)) for (const [key, { at }] of known) if (now_ms - at > KEPT_S * 1000) known.delete(key);
  }

  #hasSent(what, now, wasDropped = () => false) {
    const last = this.#lastSent.get(what);
    if (!(now.time_s > last.time_s)) return;
    this.#lastSent.set(what, now);
    let silent_ms = 1000 * (now.time_s - last.time_s);
    // Strangers also flood this program's sockets: packets dropped there were sent, so they do not count as silence.
    if (silent_ms > MOST_SILENT_MS && now.number > last.number && wasDropped()) silent_ms /= now.number - last.number;
    this.#figures.silent_ms = Math.max(this.#figures.silent_ms, silent_ms);
  }

  #isGhost(name) {
    this.#figures.ghosts.set(name, (this.#figures.ghosts.get(name) ?? 0) + 1);
  }

  #compareTracks(who, tracks, others) {
    const nearest = others.reduce((best, one) => (Math.abs(one.time - tracks.time) < Math.abs(best.time - tracks.time) ? one : best));
    const dt = tracks.time - nearest.time;
    const isFar = Math.abs(dt) > MOST_APART_S;
    // The attacked service also sends tracks for the GigE camera's images, so the other service's packets are counted.
    if (who === 'control') {
      this.#figures.tracks++;
      if (isFar) this.#figures.skippedTracks++;
    } else if (!isFar) {
      for (const [name, { at, velocity }] of nearest.things) {
        const ours = tracks.things.get(name);
        if (!ours) this.#figures.lost++;
        else this.#figures.off.push(Math.hypot(at[0] + velocity[0] * dt - ours.at[0], at[1] + velocity[1] * dt - ours.at[1]));
      }
      for (const name of tracks.things.keys()) if (!nearest.things.has(name) && !this.#alone.has(name)) this.#isGhost(name);
    }
  }
}

const percent = (share) => `${(100 * share).toFixed(1)} %`;

/** The faults in the figures of a comparison. */
export function faultsOf({ share, tracksShare, different, notFinite, max_mm, lost, ghosts, silent_ms, missed = 0 }) {
  const why = missed > 0 ? `; ${missed} packets were dropped before this program read them` : '';
  return [
    [!(share >= LEAST_COMPARED), `only ${percent(share)} of the own packets could be compared${why}`],
    [!(tracksShare >= LEAST_COMPARED), `only ${percent(tracksShare)} of the packets of tracks could be compared${why}`],
    [different > 0, `${different} own packets differ`],
    [notFinite > 0, `${notFinite} packets of tracks have no numbers`],
    [!(max_mm <= MOST_OFF_MM), `tracks are off by ${max_mm.toFixed(2)} mm`],
    [lost > 0, `${lost} times a track was missing`],
    [ghosts.size > 0, `there were ghosts: ${[...ghosts].map(([name, times]) => `${name} (${times} times)`).join(', ')}`],
    [!(silent_ms <= MOST_SILENT_MS), `nothing was sent for ${silent_ms.toFixed(0)} ms`],
  ].filter(([isWrong]) => isWrong).map(([, what]) => what);
}

export async function compare(attacked, control, alone) {
  const comparison = new Comparison(alone);
  let listeners = [];
  const sockets = [];
  const missed = () => sockets.reduce((sum, socket) => sum + socket.missed(), 0);
  let missedBefore = 0;
  for (const [who, { settings }] of Object.entries({ attacked, control })) {
    const { vision, tracker } = settings.network;
    sockets.push(await listenTo(vision.group, vision.port, (packet, { address }) => {
      if (address !== OWN_ADDRESS) return;
      comparison.hear(who, packet);
      const detection = who === 'attacked' && listeners.length > 0 ? detectionOf(packet) : null;
      if (detection) for (const listener of listeners) listener(detection);
    }));
    const tracks = await listenTo(tracker.group, tracker.port, (packet, { address }) => {
      if (address === OWN_ADDRESS) comparison.follow(who, packet, () => tracks.missed() > tracks.missedBefore);
    });
    tracks.missedBefore = 0;
    sockets.push(tracks);
  }
  const tidy = setInterval(() => {
    comparison.forget();
    for (const socket of sockets) {
      socket.misses = [...(socket.misses ?? []), socket.missed()].slice(-5); // over the last five seconds
      [socket.missedBefore] = socket.misses;
    }
  }, 1000);

  return {
    /** Restarts the comparison. */
    begin() {
      missedBefore = missed();
      comparison.begin();
    },
    end: () => ({ ...comparison.end(), missed: missed() - missedBefore }),
    /** Calls `listener` with each detection of the attacked service; returns a function that stops it. */
    listen(listener) {
      listeners.push(listener);
      return () => { listeners = listeners.filter((one) => one !== listener); };
    },
    close() {
      clearInterval(tidy);
      for (const socket of sockets) socket.close();
    },
  };
}
