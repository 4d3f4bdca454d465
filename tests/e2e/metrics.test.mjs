// SPDX-License-Identifier: Apache-2.0
// The real service's monitoring routes: /metrics, /healthz, /readyz.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { readFileSync } from 'node:fs';
import { connect } from 'node:net';
import { join } from 'node:path';
import { after, before, beforeEach, describe, it } from 'node:test';
import { becomes, createService, eventually, root } from './service.mjs';

const service = await createService('239.255.77.91');

const NAME = '[a-zA-Z_:][a-zA-Z0-9_:]*';
const LABEL = '[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\\\\n]|\\\\[\\\\"n])*"';
const SAMPLE = new RegExp(`^(${NAME})(?:\\{(${LABEL}(?:,${LABEL})*)\\})? ([+-]?(?:\\d+(?:\\.\\d+)?(?:e[+-]?\\d+)?|Inf)|NaN)$`);
const SUFFIXES = { counter: [''], gauge: [''], histogram: ['_bucket', '_sum', '_count'] };

/** Parses the text format strictly: {family: {type, samples: {'name{labels}': value}}}. */
function parse(text) {
  assert.ok(text.endsWith('\n'));
  const families = {};
  let at = null; // the family that the current lines belong to
  for (const line of text.slice(0, -1).split('\n')) {
    const head = /^# (HELP|TYPE) (\S+) (.+)$/.exec(line);
    if (head?.[1] === 'HELP') {
      assert.ok(at === null || Object.keys(at.samples).length > 0, `nothing of ${at?.name}`);
      assert.ok(!(head[2] in families), `${head[2]} twice`);
      assert.doesNotMatch(head[3], /\\(?![\\n])/);
      at = families[head[2]] = { name: head[2], type: null, samples: {} };
    } else if (head) {
      assert.equal(head[2], at.name);
      assert.equal(at.type, null);
      assert.ok(head[3] in SUFFIXES, line);
      at.type = head[3];
    } else {
      const sample = SAMPLE.exec(line);
      assert.ok(sample, `no sample: ${line}`);
      const [, name, labels = '', value] = sample;
      assert.ok(SUFFIXES[at.type].some((suffix) => name === at.name + suffix), line);
      const key = `${name}{${labels}}`;
      assert.ok(!(key in at.samples), `${key} twice`);
      at.samples[key] = value === '+Inf' ? Infinity : Number(value);
    }
  }
  return families;
}

async function ask(path) {
  const answer = await fetch(service.address(path));
  return { status: answer.status, text: await answer.text(), headers: answer.headers };
}
const metrics = async () => parse((await ask('metrics')).text);
const status = async () => (await fetch(service.address('api/status'))).json();
const value = (families, name, labels = '') => families[name].samples[`${name}{${labels}}`];

/** All values that may only grow: counters and the contents of histograms. */
function counts(families) {
  const all = Object.values(families).filter(({ type }) => type !== 'gauge').map(({ samples }) => samples);
  return Object.assign({}, ...all);
}

function assertNoneWentBack(earlier, later) {
  for (const [key, count] of Object.entries(counts(earlier))) {
    assert.ok(counts(later)[key] >= count, `${key}: ${count}, then ${counts(later)[key]}`);
  }
}

/** The buckets of each series in order, with its sum and count. */
function histograms({ name, samples }) {
  const all = {};
  for (const [key, count] of Object.entries(samples)) {
    const [, suffix, labels] = /^(_bucket|_sum|_count)\{(.*)\}$/.exec(key.slice(name.length));
    const [, series, le] = /^(.*?),?(?:le="([^"]+)")?$/.exec(labels);
    const one = all[series] ??= { buckets: [] };
    if (suffix === '_bucket') one.buckets.push([le === '+Inf' ? Infinity : Number(le), count]);
    else one[suffix] = count;
  }
  return all;
}

describe('monitoring', () => {
  before(async () => {
    await service.start();
    // Metrics about frames exist once each camera has had one.
    await service.statusBecomes(({ cameras }) => cameras.every(({ frames }) => frames > 0));
  });
  beforeEach(() => service.restore());
  after(() => service.end());

  it('uses the Prometheus format', async () => {
    const { text, headers } = await ask('metrics');
    assert.equal(headers.get('content-type'), 'text/plain; version=0.0.4; charset=utf-8');
    assert.equal(headers.get('cache-control'), 'no-store');
    const families = parse(text);
    const wanted = ['sslv_build_info', 'sslv_camera_up', 'sslv_frames_captured_total', 'sslv_frames_dropped_total', 'sslv_stage_duration_seconds',
      'sslv_capture_to_send_seconds', 'sslv_detections_total', 'sslv_camera_reconnects_total', 'sslv_packets_sent_total', 'sslv_send_errors_total',
      'sslv_preview_clients', 'sslv_config_last_reload_success_timestamp_seconds'];
    for (const name of wanted) assert.ok(name in families, name);
    for (const { name, type } of Object.values(families)) assert.equal(name.endsWith('_total'), type === 'counter', name);
    assert.equal(value(families, 'sslv_build_info', `version="${(await status()).version}"`), 1);
    for (const camera of [0, 1]) assert.equal(value(families, 'sslv_camera_up', `camera="${camera}"`), 1);
    // Only where the kernel's clock state can be read; both or neither.
    assert.equal('sslv_clock_offset_seconds' in families, 'sslv_clock_synchronized' in families);
    assert.equal('sslv_clock_offset_seconds' in families, (await (await fetch(service.address('api/diagnostics'))).json()).clock !== null);
  });

  it('has complete histograms', async () => {
    // A frame may end during the scrape, so consistency is only required within a series.
    const families = await metrics();
    const stages = histograms(families.sslv_stage_duration_seconds);
    for (const camera of [0, 1]) {
      for (const stage of ['segment', 'detect_robots', 'detect_balls', 'publish']) {
        assert.ok(stages[`camera="${camera}",stage="${stage}"`], `${camera} ${stage}`);
      }
    }
    const sent = histograms(families.sslv_capture_to_send_seconds);
    assert.deepEqual(Object.keys(sent), ['camera="0"', 'camera="1"']);
    for (const [series, { buckets, _sum: sum, _count: count }] of [...Object.entries(stages), ...Object.entries(sent)]) {
      assert.ok(buckets.length > 10 && sum >= 0 && count > 0, series);
      buckets.forEach(([le, below], i) => {
        if (i > 0) assert.ok(le > buckets[i - 1][0] && below >= buckets[i - 1][1], `${series} ${le}`);
      });
      assert.deepEqual(buckets.at(-1), [Infinity, count], series);
      const most = buckets.find(([, below]) => below === count)[0];
      assert.ok(sum <= count * most, `${series}: ${sum}`);
    }
  });

  it('agrees with the status, and grows', async () => {
    const first = await metrics();
    // A status read between two scrapes must lie between them.
    const [earlier, now, later] = [await metrics(), await status(), await metrics()];
    const between = (shown, name, labels = '') => {
      const [least, most] = [value(earlier, name, labels), value(later, name, labels)];
      assert.ok(least <= shown + 1 && shown <= most + 1, `${name}{${labels}}: ${least} <= ${shown} <= ${most}`);
    };
    assert.equal(now.cameras.length, 2);
    for (const { id, frames, frames_dropped, frames_incomplete, reconnects } of now.cameras) {
      between(frames, 'sslv_frames_captured_total', `camera="${id}"`);
      between(frames_dropped, 'sslv_frames_dropped_total', `camera="${id}",reason="not_processed"`);
      between(frames_incomplete, 'sslv_frames_dropped_total', `camera="${id}",reason="damaged"`);
      between(reconnects, 'sslv_camera_reconnects_total', `camera="${id}"`);
    }
    between(now.network.packets_sent, 'sslv_packets_sent_total');
    between(now.network.send_errors, 'sslv_send_errors_total');
    assert.equal(value(later, 'sslv_preview_clients'), now.viewers);
    assertNoneWentBack(earlier, later);
    const grown = await becomes(metrics, (families) => ['sslv_frames_captured_total{camera="0"}', 'sslv_frames_captured_total{camera="1"}', 'sslv_packets_sent_total{}',
      'sslv_detections_total{camera="0",kind="robot_yellow"}', 'sslv_detections_total{camera="0",kind="robot_blue"}', 'sslv_capture_to_send_seconds_count{camera="1"}']
      .every((key) => counts(families)[key] > counts(first)[key]));
    assertNoneWentBack(later, grown);
  });

  it('counts viewers, not their second connections', async () => {
    assert.equal(value(await metrics(), 'sslv_preview_clients'), 0);
    const open = async (query) => {
      const socket = connect(service.settings.panel.port, '127.0.0.1');
      socket.write(`GET /api/ws${query} HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n` +
        'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n');
      const [answer] = await once(socket, 'data');
      assert.match(answer.toString('latin1'), /^HTTP\/1.1 101 /);
      return socket;
    };
    const second = await open('?second'), socket = await open('');
    await becomes(metrics, (families) => value(families, 'sslv_preview_clients') === 1);
    const connections = async () => (await (await fetch(service.address('api/diagnostics'))).json()).web.connections;
    const before = await connections();
    second.destroy();
    await becomes(connections, (now) => now < before);
    assert.equal(value(await metrics(), 'sslv_preview_clients'), 1);
    socket.destroy();
    await becomes(metrics, (families) => value(families, 'sslv_preview_clients') === 0);
  });

  it('reports when settings took effect', async () => {
    const name = 'sslv_config_last_reload_success_timestamp_seconds';
    const earlier = value(await metrics(), name);
    assert.ok(Math.abs(earlier - Date.now() / 1000) < 600);
    await service.patch({ op: 'replace', path: '/site', value: 'Watched' });
    const later = value(await metrics(), name);
    assert.ok(later > earlier);
    await fetch(service.address('api/settings'), { method: 'PATCH', body: JSON.stringify([{ op: 'replace', path: '/site', value: 7 }]) });
    assert.equal(value(await metrics(), name), later, 'a refused change is none');
  });

  it('never counts back: a camera opened anew, lost, with another stack, taken out and put back', async () => {
    const path = '/cameras/1';
    const [camera] = service.settings.cameras.slice(1);
    const { settings } = await (await fetch(service.address('api/settings'))).json();
    const changes = [
      { op: 'replace', path: `${path}/source/seed`, value: 77 },
      { op: 'replace', path: `${path}/source`, value: { backend: 'files', path: join(service.folder, 'not-there') } },
      { op: 'replace', path: `${path}/source`, value: camera.source },
      { op: 'replace', path: `${path}/stack`, value: ['threshold', 'find_runs', 'find_regions', 'detect_robots', 'detect_balls', 'publish'] },
      { op: 'replace', path: `${path}/stack`, value: settings.cameras[1].stack },
      { op: 'remove', path },
      { op: 'add', path, value: settings.cameras[1] },
    ];
    const frames = 'sslv_frames_captured_total{camera="1"}';
    let earlier = await metrics();
    for (const change of changes) {
      await service.patch(change);
      let later = await metrics();
      if (change.op === 'remove') {
        assert.equal(value(later, 'sslv_camera_up', 'camera="1"'), undefined);
        continue; // its counters are kept: it may be added again
      }
      assertNoneWentBack(earlier, later);
      if (change.value.backend === 'files') continue; // which delivers no frames
      later = await becomes(metrics, (families) => counts(families)[frames] > counts(earlier)[frames] + 2);
      assertNoneWentBack(earlier, later);
      earlier = later;
    }
    assert.ok(counts(earlier)['sslv_stage_duration_seconds_count{camera="1",stage="threshold"}'] > 0, 'also of a stage that is in no stack any more');
  });

  it('is ready while every camera runs', async () => {
    await becomes(() => ask('readyz'), ({ status: code, text }) => code === 200 && text === 'ok\n');
    const path = '/cameras/1/source';
    await service.patch({ op: 'replace', path, value: { backend: 'files', path: join(service.folder, 'not-there') } });
    const lost = await becomes(() => ask('readyz'), ({ status: code, text }) => code === 503 && text.includes('lost'));
    assert.match(lost.text, /^camera 1 is lost: .*not-there.*\n$/);
    assert.match(lost.headers.get('content-type'), /^text\/plain/);
    assert.equal(value(await metrics(), 'sslv_camera_up', 'camera="1"'), 0);
    assert.equal(value(await metrics(), 'sslv_camera_up', 'camera="0"'), 1);
    assert.deepEqual([(await ask('healthz')).status, (await ask('healthz')).text], [200, 'ok\n'], 'a camera that is looked for is no fault of the service');
    await service.patch({ op: 'replace', path, value: service.settings.cameras[1].source });
    await becomes(() => ask('readyz'), ({ status: code }) => code === 200);
  });

  it('is ready while packets leave', async () => {
    await service.patch({ op: 'replace', path: '/network/vision/interface', value: 'no-such-card' });
    // On a busy computer it may have been unready before, for another reason.
    const { status } = await becomes(() => ask('readyz'), ({ text }) => /^No packets are sent: .*no-such-card.*\n$/.test(text));
    assert.equal(status, 503);
    const earlier = await metrics();
    await becomes(metrics, (families) => value(families, 'sslv_send_errors_total') > value(earlier, 'sslv_send_errors_total'));
    await service.patch({ op: 'replace', path: '/network/vision/interface', value: 'lo' });
    await becomes(() => ask('readyz'), ({ status: code }) => code === 200);
    assertNoneWentBack(earlier, await metrics());
  });

  it('allows only GET and HEAD', async () => {
    await eventually(async () => assert.equal((await ask('readyz')).status, 200));
    for (const path of ['metrics', 'healthz', 'readyz']) {
      const head = await fetch(service.address(path), { method: 'HEAD' });
      assert.equal(head.status, 200, path);
      assert.match(head.headers.get('content-type'), /^text\/plain/);
      assert.equal(await head.text(), '');
      const post = await fetch(service.address(path), { method: 'POST' });
      assert.deepEqual([post.status, post.headers.get('allow')], [405, 'GET'], path);
    }
  });

  it('finds in docs/monitoring only metrics that there are', async () => {
    const families = await metrics();
    const names = new Set(Object.values(families).flatMap(({ name, type }) => SUFFIXES[type].map((suffix) => name + suffix)));
    for (const clock of ['sslv_clock_offset_seconds', 'sslv_clock_synchronized']) names.add(clock); // absent in some containers
    const dashboard = JSON.parse(readFileSync(join(root, 'docs/monitoring/grafana.json'), 'utf8'));
    const queries = dashboard.panels.flatMap(({ targets = [] }) => targets.map(({ expr }) => expr));
    const rules = readFileSync(join(root, 'docs/monitoring/alerts.yml'), 'utf8');
    assert.ok(queries.length >= 6);
    const used = [...queries.join(' ').matchAll(/sslv_\w+/g), ...rules.matchAll(/sslv_\w+/g)].map(([name]) => name);
    assert.ok(used.length > 12);
    for (const name of used) assert.ok(names.has(name), `${name} is no metric`);
  });
});
