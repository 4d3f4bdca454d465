// SPDX-License-Identifier: Apache-2.0
import { createCipheriv, createHash } from 'node:crypto';
import { gzipSync } from 'node:zlib';

const MIB = 1024 * 1024;
const HOLE_BYTES = 64 * 1024; // distance between the starts of two pieces

/** A header block of a tar. `at386`: the sparse map in GNU's format. */
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
/** A sparse file with more pieces than fit into its header, followed by extension blocks (GNU tar). */
function manyPieces(count) {
  const piece = (i) => octal(i * HOLE_BYTES) + octal(1);
  const records = Array.from({ length: Math.ceil(count / 21) }, (_, at, isLast = at === Math.ceil(count / 21) - 1) => {
    const bytes = Buffer.alloc(512);
    bytes.write(Array.from({ length: 21 }, (_, i) => piece(4 + 21 * at + i)).join(''), 'latin1');
    bytes[504] = isLast ? 0 : 1;
    return bytes;
  });
  const pieces = 4 + 21 * records.length;
  const first = [0, 1, 2, 3].map(piece).join('');
  return Buffer.concat([record('sparse', pieces, 'S', `${first}\x01${octal(pieces * HOLE_BYTES).trim()}`), ...records, padded(Buffer.alloc(pieces, 'x')), END]);
}
/** The same in the current format: a map before the file's own data (GNU tar, pax 1.0). */
function manyPiecesOfPax(count) {
  const line = (text) => {
    const rest = ` ${text}\n`;
    const length = [1, 2, 3].find((digits) => `${rest.length + digits}`.length === digits) + rest.length;
    return `${length}${rest}`;
  };
  const pax = Buffer.from(['major=1', 'minor=0', 'name=sparse', `realsize=${count * HOLE_BYTES}`].map((one) => line(`GNU.sparse.${one}`)).join(''));
  const map = padded(Buffer.from(`${count}\n${Array.from({ length: count }, (_, i) => `${i * HOLE_BYTES}\n1\n`).join('')}`));
  const data = Buffer.concat([map, Buffer.alloc(count, 'x')]);
  return Buffer.concat([record('PaxHeaders/sparse', pax.length, 'x'), padded(pax), record('GNUSparseFile.0/sparse', data.length), padded(data), END]);
}
const padded = (bytes) => Buffer.concat([bytes, Buffer.alloc((512 - (bytes.length % 512)) % 512)]);
const END = Buffer.alloc(1024);
const tar = (files) => Buffer.concat([...files.flatMap(([name, content]) => [record(name, content.length), padded(content)]), END]);
const sumOf = (bytes) => createHash('sha256').update(bytes).digest('hex');
const manifest = Buffer.from(JSON.stringify({ format: 'ssl-visiond backup', format_version: 1, version: '1', time: 1, computer: 'pc', site: '' }));
/** Incompressible data, faster than random.bytes(). */
const unpackable = (random, size) => createCipheriv('aes-128-ctr', random.bytes(16), random.bytes(16)).update(Buffer.alloc(size));
/** With correct checksums. */
const backup = (files) => {
  const all = [['manifest.json', manifest], ...files.map(([name, content]) => [name, Buffer.from(content)])];
  return gzipSync(tar([...all, ['SHA256SUMS', Buffer.from(all.map(([name, content]) => `${sumOf(content)}  ${name}\n`).join(''))]]));
};
const repeated = (text, size) => text.repeat(Math.ceil(size / text.length));
const table = Buffer.concat([Buffer.from('SSLVLUT2'), Buffer.from([8, 1, 0, 0, 0, 0x80, 0x80, 0x80, 0x08])]);

/** Three tables with `size` incompressible bytes and `zeros` zero bytes each. */
const tables = (random, size, zeros) => Array.from({ length: 3 }, () => {
  const bytes = Buffer.concat([Buffer.from('SSLVLUT1'), unpackable(random, Math.floor(size)), Buffer.alloc(Math.floor(zeros))]);
  return [`tables/${sumOf(bytes).slice(0, 16)}.lut`, bytes];
});

const settings = ['settings.json', '{"version":2,"revision":1,"history":[],"settings":{"site":7}}']; // refused only after everything else was read
/** Forged backups, by description. */
export const FORGED = {
  'a file with a hole of 750 MiB': () => gzipSync(Buffer.concat([record('sparse', 0, 'S', octal(750 * MIB) + octal(0) + '\0'.repeat(73) + octal(750 * MIB).trim()), END])),
  'a file of 8000 pieces in 500 MiB': () => gzipSync(manyPieces(8000)),
  'the same as pax says it': () => gzipSync(manyPiecesOfPax(8000)),
  '200 MiB of spaces': () => gzipSync(tar([['settings.json', Buffer.alloc(200 * MIB, 0x20)]])),
  'many large files': () => gzipSync(tar(Array.from({ length: 9 }, (_, i) => [`${i}`, Buffer.alloc(6 * MIB)]))),
  'many small files': () => gzipSync(tar(Array.from({ length: 20_000 }, (_, i) => [`${i}`, Buffer.alloc(0)]))),
  'settings of lists': () => backup([['settings.json', `[${repeated('[],', 8 * MIB)}0]`]]),
  'settings of empty texts': () => backup([['settings.json', `{"version":2,"revision":1,"history":[],"settings":{"site":[${repeated('"",', 8 * MIB)}""]}}`]]),
  'settings that just fit': () => backup([['settings.json', `{"version":2,"revision":1,"history":[],"settings":{"site":[${repeated('[],', 386_000)}0]}}`]]),
  'profiles of nothing': () => backup([settings, ['profiles.json', `{"profiles":[${repeated('{},', 8 * MIB)}{}]}`]]),
  'profiles that just fit': () => backup([settings, ['profiles.json', `{"profiles":[${repeated('{},', 780_000)}{}]}`]]),
  'calibrations of numbers': () => backup([settings, ['calibrations.json', `[${repeated('0,', 8 * MIB)}0]`]]),
  '2000 tables': () => backup(Array.from({ length: 2000 }, (_, i) => Buffer.concat([table, Buffer.from([i & 255, i >> 8])])).map((bytes) => [`tables/${sumOf(bytes).slice(0, 16)}.lut`, bytes])),
  'large tables': (random) => backup([settings, ...tables(random, MIB, 6.5 * MIB)]),
  // 8 MiB compressed and 24 MiB unpacked: the most that a backup may have.
  'tables that just fit': (random) => backup([settings, ...tables(random, 2.6 * MIB, 5.3 * MIB)]),
  'bytes that are packed': (random) => gzipSync(random.bytes(MIB)),
  'bytes that are none': (random) => random.bytes(MIB),
};

export default {
  name: 'forged backups',
  about: 'an admin checks forged backups: sparse, with many files, with JSON that needs much memory, mutations',
  async run({ ask, random, isOver, pause, check }) {
    const { admin } = await ask.cookies();
    while (!isOver()) {
      const file = random.pick(Object.values(FORGED))(random);
      const body = random.below(4) ? file : random.mutated(file);
      const { status, text } = await ask('POST', 'api/backup/check', { body, cookie: admin });
      check([413, 422, 503].includes(status), `a forged backup is answered with ${status}: ${text.slice(0, 200)}`);
      await pause(200);
    }
  },
};
