// SPDX-License-Identifier: Apache-2.0
// Checks that ./run strangers finds faults in a service's packets, and fails if it received none.
import assert from 'node:assert/strict';
import { describe, it } from 'node:test';
import { Comparison, faultsOf } from './compare.mjs';
import { detection, tracked } from './wire.mjs';

const BEGIN_S = 1_000_000, STEP_S = 0.05, STEPS = 100;
const ROBOT = { id: 3, team: 1, position: [1, 2] }, BALL = [0.5, 0.5, 0];
const moment = (i) => BEGIN_S + i * STEP_S;
const image = (i, camera, more = {}) => detection({ frame: i, capture: moment(i), sent: moment(i), camera, yellow: [{ id: 3, x: 1000, y: 2000 }], ...more });
const tracks = (i, more = {}) => tracked({ frame: i, time: moment(i), balls: [BALL], robots: [ROBOT], ...more });

/** The faults after 5 s of two services; `vision` and `track` return the attacked service's packet for a moment, or
 * null. */
function faults({ vision = image, track = tracks, controlToo = true, wasDropped, alone = ['yellow 12'] } = {}) {
  const comparison = new Comparison(alone);
  comparison.begin(1000 * BEGIN_S);
  const send = (who, sees, follows, i) => {
    for (const camera of [0, 1]) {
      const packet = sees(i, camera);
      if (packet) comparison.hear(who, packet, 1000 * moment(i));
    }
    const packet = follows(i);
    if (packet) comparison.follow(who, packet, wasDropped);
  };
  for (let i = 1; i <= STEPS; ++i) {
    send('attacked', vision, track, i); // first, before the other service's packet of that moment
    if (controlToo) send('control', image, tracks, i);
  }
  return faultsOf(comparison.end(1000 * moment(STEPS)));
}
const isOne = (found, text) => assert.ok(found.length === 1 && text.test(found[0]), JSON.stringify(found));

describe('packets of two services', () => {
  it('are the same when nothing is wrong', () => assert.deepEqual(faults(), []));

  it('are compared with something, or that is a fault', () => {
    assert.match(faults({ controlToo: false })[0], /^only 0.0 % of the own packets/);
    assert.match(faults({ vision: () => null, track: () => null }).join(), /^only 0.0 % of the own packets.*only 0.0 % of the packets of tracks.*nothing was sent for 5000 ms/);
  });

  it('that differ, or are not finite', () => {
    isOne(faults({ vision: (i, camera) => image(i, camera, i === 50 ? { balls: [{}] } : {}) }), /^2 own packets differ/);
    assert.match(faults({ track: (i) => tracks(i, { robots: [{ ...ROBOT, position: [i === 50 ? NaN : 1, 2] }] }) }).join(), /1 packets of tracks have no numbers/);
    isOne(faults({ track: (i) => tracks(i, { robots: [{ ...ROBOT, position: [i === 50 ? 1.01 : 1, 2] }] }) }), /^tracks are off by 10.00 mm/);
  });

  it('that are missing', () => {
    isOne(faults({ vision: (i, camera) => (i % 10 ? image(i, camera) : null) }), /^only 90.0 % of the own packets/);
    isOne(faults({ track: (i) => (i % 10 ? tracks(i) : null) }), /^only 90.0 % of the packets of tracks/);
    assert.deepEqual(faults({ vision: (i, camera) => (i === 50 ? null : image(i, camera)), track: (i) => (i === 50 ? null : tracks(i)) }), []);
    assert.match(faults({ track: (i) => (i > 40 && i < 65 ? null : tracks(i)) }).at(-1), /^nothing was sent for 1250 ms/);
    assert.doesNotMatch(faults({ track: (i) => (i > 40 && i < 65 ? null : tracks(i)), wasDropped: () => true }).join(), /nothing was sent/);
    assert.match(faults({ vision: (i, camera) => (camera === 1 && i > 75 ? null : image(i, camera)) }).at(-1), /^nothing was sent for 1250 ms/);
  });

  it('with robots or balls that are lost, or that are none', () => {
    isOne(faults({ track: (i) => tracks(i, i === 50 ? { robots: [] } : {}) }), /^1 times a track was missing/);
    isOne(faults({ track: (i) => tracks(i, i === 50 ? { robots: [ROBOT, { ...ROBOT, id: 7 }] } : {}) }), /^there were ghosts: yellow 7 \(1 times\)/);
    isOne(faults({ track: (i) => tracks(i, i === 50 ? { robots: [ROBOT, ROBOT] } : {}) }), /^there were ghosts: yellow 3 again/);
    isOne(faults({ track: (i) => tracks(i, i === 50 ? { balls: [BALL, [1, 1, 0]] } : {}) }), /^there were ghosts: ball again/);
    isOne(faults({ vision: (i, camera) => image(i, i === 50 && camera === 1 ? 40 : camera) }), /^there were ghosts: camera 40/);
  });

  it('with robots that only the attacked one sees, and tracks for images that are its alone', () => {
    assert.deepEqual(faults({ track: (i) => tracks(i, { robots: [ROBOT, { ...ROBOT, id: 12 }] }) }), []);
    const comparison = new Comparison();
    comparison.begin(1000 * BEGIN_S);
    for (let i = 1; i <= STEPS; ++i) {
      for (const who of ['attacked', 'control']) {
        for (const camera of [0, 1]) comparison.hear(who, image(i, camera), 1000 * moment(i));
        comparison.follow(who, tracks(i));
      }
      comparison.follow('attacked', tracks(i + 0.5));
    }
    assert.deepEqual(faultsOf(comparison.end(1000 * moment(STEPS))), []);
  });
});
