// SPDX-License-Identifier: Apache-2.0
// Run by faults_run.test.mjs in a network namespace: the network card is removed and restored, packets stay on the
// computer although there is a card, and a program binds the port for itself. Exit code 77: the kernel has no virtual cards.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { once } from 'node:events';
import { readlinkSync } from 'node:fs';
import { FaultyService, report, tries } from './faults.mjs';
import { becomes } from './service.mjs';

const ip = (...words) => execFileSync('ip', words, { stdio: 'pipe' });
const ADDRESS = '10.77.0.1';
function putIn() {
  ip('link', 'add', 'field0', 'type', 'veth', 'peer', 'name', 'switch0');
  ip('address', 'add', `${ADDRESS}/24`, 'dev', 'field0');
  for (const card of ['switch0', 'field0']) ip('link', 'set', card, 'up');
}

ip('link', 'set', 'lo', 'up');
try {
  putIn();
} catch (error) {
  console.error(String(error.stderr ?? error));
  process.exit(77);
}
const service = new FaultyService('239.255.79.99');
service.settings.network.vision.interface = 'field0';
// No port is taken in this namespace. A reserved one would be shared, so no program could bind it for itself.
service.settings.network.vision.port = 10006;

/** A program that binds the port without SO_REUSEADDR, as some teams' do, and receives packets. */
async function bindAlone() {
  const { group, port } = service.settings.network.vision;
  const socket = createSocket('udp4').bind(port);
  await once(socket, 'listening');
  socket.addMembership(group, ADDRESS);
  return socket;
}

try {
  service.writeSettings();
  const before = await bindAlone();
  await service.start();
  await once(before, 'message');
  assert.ok(!(await service.status()).alerts.some(({ id }) => id === 'group_not_heard'));
  before.close();
  const after = await bindAlone();
  await once(after, 'message');
  after.close();

  await service.set('/network/vision/interface', 'lo');
  assert.match((await service.alertComes('only_this_computer')).fix, /field0/);
  const { checks } = await service.status();
  assert.equal(checks.find(({ id }) => id === 'network').state, 'warn');
  await service.set('/network/vision/interface', 'field0');
  await service.alertGoes('only_this_computer');

  // The cable is unplugged: the card itself is still up and accepts every packet.
  ip('link', 'set', 'switch0', 'down');
  assert.match((await service.alertComes('card_no_link')).title, /field0/);
  assert.equal((await service.status()).network.error, '');
  await service.set('/network/vision/interface', 'lo');
  await service.alertGoes('card_no_link');
  await service.set('/network/vision/interface', '');
  ip('route', 'add', '224.0.0.0/4', 'dev', 'field0');
  await service.alertComes('card_no_link');
  ip('link', 'set', 'switch0', 'up');
  await service.alertGoes('card_no_link');
  await service.set('/network/vision/interface', 'field0');

  // Two cards: the system's routes choose the first, and a computer of the field is on the second.
  const field = spawn('unshare', ['--net', 'sleep', 'infinity'], { stdio: 'ignore' });
  const onField = (...words) => execFileSync('nsenter', ['--net', '--target', String(field.pid), ...words], { stdio: 'pipe' });
  try {
    ip('link', 'add', 'other0', 'type', 'veth', 'peer', 'name', 'team0');
    ip('address', 'add', '10.78.0.1/24', 'dev', 'other0');
    ip('link', 'set', 'other0', 'up');
    await becomes(() => readlinkSync(`/proc/${field.pid}/ns/net`), (net) => net !== readlinkSync('/proc/self/ns/net'));
    ip('link', 'set', 'team0', 'netns', String(field.pid));
    onField('ip', 'address', 'add', '10.78.0.2/24', 'dev', 'team0');
    onField('ip', 'link', 'set', 'team0', 'up');
    onField('ip', 'route', 'add', '224.0.0.0/4', 'dev', 'team0');
    await service.set('/network/vision/interface', '');
    assert.match((await service.alertComes('card_not_chosen')).title, /field0 \(10\.77\.0\.1\)/);
    const { group, port } = service.settings.network.vision;
    const say = `const s = require('dgram').createSocket('udp4'); setInterval(() => s.send('x', ${port}, '${group}'), 100)`;
    const team = spawn('nsenter', ['--net', '--target', String(field.pid), process.execPath, '-e', say], { stdio: 'ignore' });
    try {
      assert.match((await service.alertComes('card_wrong')).title, /field0 .*10\.78\.0\.2 is on other0/);
      await service.alertGoes('card_not_chosen');
      await service.set('/network/vision/interface', 'lo');
      await service.alertGoes('card_wrong');
      await service.set('/network/vision/interface', 'field0');
      await service.alertComes('card_wrong');
      const refused = async () => (await service.status()).network.packets_refused;
      assert.equal(await refused(), 0, 'packets on another card are not believed');
      await service.set('/network/vision/interface', 'other0');
      await becomes(service.status, ({ checks, alerts }) => !alerts.some(({ id }) => id === 'card_wrong')
        && checks.find(({ id }) => id === 'network').text.endsWith(' on other0 (10.78.0.1)'));
      await becomes(refused, (count) => count > 0);
    } finally {
      team.kill();
    }
    ip('link', 'delete', 'other0');
    await service.set('/network/vision/interface', 'field0');
  } finally {
    field.kill();
  }

  const rounds = tries(4, 50);
  const times = [];
  let frames = 0, refused = 0, lost = 0;
  for (let round = 0; round < rounds; round++) {
    let packets = await service.listen(ADDRESS);
    await packets.more(0, 3);
    packets.close();
    round % 2 ? ip('link', 'set', 'field0', 'down') : ip('link', 'delete', 'field0');
    const { fix } = await service.alertComes('not_sending');
    assert.match(fix, /field0|the service tries again automatically/);
    const { network, cameras: [before] } = await service.status();
    const { cameras: [later] } = await becomes(service.status, ({ cameras: [now] }) => now.frames > before.frames + 5);
    assert.equal(later.state, 'running', 'pictures are taken meanwhile');
    if (round % 2) ip('link', 'set', 'field0', 'up');
    else putIn();
    const began = performance.now();
    packets = await service.listen(ADDRESS);
    await packets.more(0, 1);
    times.push(packets.frames[0].at_ms - began);
    await packets.more(0, 10);
    lost += packets.lost(0);
    frames += packets.frames.length;
    refused += (await service.status()).network.send_errors - network.send_errors;
    packets.close();
    await service.alertGoes('not_sending');
  }
  await service.stop();
  assert.ok(refused >= 0 && frames >= 10 * rounds);
  report('network card taken out, or its link down, and put back', rounds, lost, times);
  assert.equal(lost, 0, 'once they leave none is missing');
} finally {
  await service.remove();
}
