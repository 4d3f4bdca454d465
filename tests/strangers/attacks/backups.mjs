// SPDX-License-Identifier: Apache-2.0
import { createHash } from 'node:crypto';
import { gzipSync } from 'node:zlib';

const MIB = 1024 * 1024;

/** A block of a tar. `at386`: what GNU's sparse files have there. */
function record(name, size, type = '0', at386 = '') {
  const head = Buffer.alloc(512);
  const put = (at, text) => head.write(text, at, 'latin1');
  put(0, name.slice(0, 99));
  put(100, '0000644');
  put(124, size.toString(8).padStart(11, '0'));
  put(136, '00000000000');
  put(156, type);
  put(257, 'ustar  \0');
  put(386, at386);
  put(148, '        ');
  put(148, `${head.reduce((sum, byte) => sum + byte, 0).toString(8).padStart(6, '0')}\0 `);
  return head;
}
const octal = (number) => `${number.toString(8).padStart(11, '0')} `;
const padded = (bytes) => Buffer.concat([bytes, Buffer.alloc((512 - (bytes.length % 512)) % 512)]);
const END = Buffer.alloc(1024);
const tar = (files) => Buffer.concat([...files.flatMap(([name, content]) => [record(name, content.length), padded(content)]), END]);
const sumOf = (bytes) => createHash('sha256').update(bytes).digest('hex');
const manifest = Buffer.from(JSON.stringify({ format: 'ssl-visiond backup', format_version: 1, version: '1', time: 1, computer: 'pc', site: '' }));
/** With sums that are right. */
const backup = (files) => {
  const all = [['manifest.json', manifest], ...files.map(([name, content]) => [name, Buffer.from(content)])];
  return gzipSync(tar([...all, ['SHA256SUMS', Buffer.from(all.map(([name, content]) => `${sumOf(content)}  ${name}\n`).join(''))]]));
};
const repeated = (text, size) => text.repeat(Math.ceil(size / text.length));
const table = Buffer.concat([Buffer.from('SSLVLUT2'), Buffer.from([8, 1, 0, 0, 0, 0x80, 0x80, 0x80, 0x08])]);

const settings = ['settings.json', '{"version":2,"revision":1,"history":[],"settings":{"site":7}}']; // refused after all else was read
/** What a file may be that is none of ours, by what it is. */
export const FORGED = {
  'a file with a hole of 750 MiB': () => gzipSync(Buffer.concat([record('sparse', 0, 'S', octal(750 * MIB) + octal(0) + '\0'.repeat(73) + octal(750 * MIB).trim()), END])),
  '200 MiB of spaces': () => gzipSync(tar([['settings.json', Buffer.alloc(200 * MIB, 0x20)]])),
  'many large files': () => gzipSync(tar(Array.from({ length: 9 }, (_, i) => [`${i}`, Buffer.alloc(6 * MIB)]))),
  'many small files': () => gzipSync(tar(Array.from({ length: 20_000 }, (_, i) => [`${i}`, Buffer.alloc(0)]))),
  'settings of lists': () => backup([['settings.json', `[${repeated('[],', 8 * MIB)}0]`]]),
  'settings of empty texts': () => backup([['settings.json', `{"version":2,"revision":1,"history":[],"settings":{"site":[${repeated('"",', 8 * MIB)}""]}}`]]),
  'settings that just fit': () => backup([['settings.json', `{"version":2,"revision":1,"history":[],"settings":{"site":[${repeated('[],', 780_000)}0]}}`]]),
  'profiles of nothing': () => backup([settings, ['profiles.json', `{"profiles":[${repeated('{},', 8 * MIB)}{}]}`]]),
  'profiles that just fit': () => backup([settings, ['profiles.json', `{"profiles":[${repeated('{},', 780_000)}{}]}`]]),
  'calibrations of numbers': () => backup([settings, ['calibrations.json', `[${repeated('0,', 8 * MIB)}0]`]]),
  '2000 tables': () => backup(Array.from({ length: 2000 }, (_, i) => Buffer.concat([table, Buffer.from([i & 255, i >> 8])])).map((bytes) => [`tables/${sumOf(bytes).slice(0, 16)}.lut`, bytes])),
  'large tables': (random) => backup([settings, ...Array.from({ length: 3 }, () => Buffer.concat([Buffer.from('SSLVLUT1'), random.bytes(2 * MIB), Buffer.alloc(7 * MIB)])).map((bytes) => [`tables/${sumOf(bytes).slice(0, 16)}.lut`, bytes])]),
  'bytes that are packed': (random) => gzipSync(random.bytes(MIB)),
  'bytes that are none': (random) => random.bytes(MIB),
};

export default {
  name: 'forged backups',
  about: 'an admin checks files that somebody sent: sparse, of many files, of JSON that fills memory, mutations',
  async run({ ask, random, isOver, pause, check }) {
    const { admin } = await ask.cookies();
    while (!isOver()) {
      const file = random.pick(Object.values(FORGED))(random);
      const body = random.below(4) ? file : random.mutated(file);
      const { status } = await ask('POST', 'api/backup/check', { body, cookie: admin });
      check([413, 422, 503].includes(status), `a forged backup is answered with ${status}`);
      await pause(200);
    }
  },
};
