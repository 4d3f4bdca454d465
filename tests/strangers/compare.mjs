// SPDX-License-Identifier: Apache-2.0
// Packets and tracks of a service, beside those of one like it that no stranger knows of. Both draw the same scene at the
// same moments, so what their cameras say of an image is the same byte by byte, but for when it was sent.
import { detectionOf, fieldsOf } from '../e2e/protobuf.mjs';
import { listenTo } from '../e2e/service.mjs';

const OWN_ADDRESS = '127.0.0.1'; // strangers have others
const KEPT_S = 5;
const CAPTURE = 2, CAMERA = 4, BALLS = 5, YELLOW = 6, BLUE = 7;
const UUID = 1, TRACKED = 3;

/** What a camera says of an image: {key: which image, body}. */
function sightingsOf(packet) {
  const frame = fieldsOf(packet)[1]?.[0];
  if (!frame) return null;
  const f = fieldsOf(frame);
  const body = Buffer.concat([BALLS, YELLOW, BLUE].flatMap((number) => [Buffer.from([number]), ...(f[number] ?? [])]));
  return { camera: f[CAMERA][0], key: `${f[CAMERA][0]} ${f[CAPTURE][0].toString('hex')}`, body: body.toString('base64') };
}

const floats = (bytes) => Object.values(fieldsOf(bytes)).map(([one]) => one.readFloatLE(0) * 1000);
/** {time, things: Map name -> {at, velocity}} in mm and s; null for what holds no tracks. */
function tracksOf(packet) {
  const outer = fieldsOf(packet);
  if (!outer[TRACKED]) return null;
  const f = fieldsOf(outer[TRACKED][0]);
  const things = new Map();
  for (const bytes of f[4] ?? []) {
    const { 1: [id], 2: [at], 4: velocity } = fieldsOf(bytes);
    const { 1: [number], 2: [team] } = fieldsOf(id);
    things.set(`${team === 1 ? 'yellow' : 'blue'} ${number}`, { at: floats(at), velocity: velocity ? floats(velocity[0]) : [0, 0] });
  }
  const ball = f[3]?.[0] && fieldsOf(f[3][0]);
  if (ball) things.set('ball', { at: floats(ball[1][0]).slice(0, 2), velocity: ball[2] ? floats(ball[2][0]).slice(0, 2) : [0, 0] });
  return { uuid: outer[UUID][0].toString(), time: f[2][0].readDoubleLE(0), things };
}

export async function compare(attacked, control) {
  const images = { attacked: new Map(), control: new Map() };
  let lastTracks = []; // of the control, the newest ones
  let figures, listeners = [];
  const begin = () => { figures = { frames: { attacked: 0, control: 0 }, compared: 0, different: [], tracks: 0, off: [], notFinite: 0, lost: 0, last: Date.now() }; };
  begin();

  const hear = (who, packet, from) => {
    if (from.address !== OWN_ADDRESS) return;
    const sightings = sightingsOf(packet);
    if (!sightings) return;
    if (who === 'attacked') for (const listener of listeners) listener(detectionOf(packet));
    if (sightings.camera > 1) return; // the GigE camera is the attacked one's alone
    figures.frames[who]++;
    const other = images[who === 'attacked' ? 'control' : 'attacked'];
    const theirs = other.get(sightings.key);
    if (theirs === undefined) return void images[who].set(sightings.key, { body: sightings.body, at: Date.now() });
    other.delete(sightings.key);
    figures.compared++;
    if (theirs.body !== sightings.body) figures.different.push(sightings.key);
  };
  const follow = (who, packet, from) => {
    if (from.address !== OWN_ADDRESS) return;
    const tracks = tracksOf(packet);
    if (!tracks) return;
    if (who === 'control') {
      lastTracks = [...lastTracks.slice(-50), tracks];
      return;
    }
    figures.last = Date.now();
    if (!Number.isFinite(tracks.time) || [...tracks.things.values()].some(({ at }) => at.some((one) => !Number.isFinite(one)))) figures.notFinite++;
    const nearest = lastTracks.reduce((best, one) => (Math.abs(one.time - tracks.time) < Math.abs((best?.time ?? Infinity) - tracks.time) ? one : best), null);
    if (!nearest || Math.abs(nearest.time - tracks.time) > 0.02) return;
    const dt = tracks.time - nearest.time;
    for (const [name, { at, velocity }] of nearest.things) {
      const theirs = tracks.things.get(name);
      if (!theirs) figures.lost++;
      else figures.off.push(Math.hypot(at[0] + velocity[0] * dt - theirs.at[0], at[1] + velocity[1] * dt - theirs.at[1]));
      figures.tracks++;
    }
  };
  const sockets = [];
  for (const [who, { settings }] of Object.entries({ attacked, control })) {
    const { vision, tracker } = settings.network;
    sockets.push(await listenTo(vision.group, vision.port, (packet, from) => hear(who, packet, from)));
    sockets.push(await listenTo(tracker.group, tracker.port, (packet, from) => follow(who, packet, from)));
  }
  const tidy = setInterval(() => {
    for (const known of Object.values(images)) for (const [key, { at }] of known) if (Date.now() - at > KEPT_S * 1000) known.delete(key);
  }, 1000);

  return {
    /** From now on. */
    begin,
    end() {
      const { off, different, ...others } = figures;
      const sorted = [...off].sort((a, b) => a - b);
      const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(sorted.length * share))] ?? NaN;
      return { ...others, different: different.length, p50_mm: at(0.5), p99_mm: at(0.99), max_mm: at(1), silent_ms: Date.now() - figures.last };
    },
    /** Each detection of the attacked service; returns how to stop. */
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
