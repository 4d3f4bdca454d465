// SPDX-License-Identifier: Apache-2.0
import { closeSync, mkdirSync, openSync, rmSync, truncateSync, writeFileSync, writeSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';

/** Files as a USB stick may contain; the sparse ones take no space on the disk. */
function make(folder, random) {
  mkdirSync(folder, { recursive: true });
  const files = [];
  const put = (name, bytes, size) => {
    const path = join(folder, name);
    const file = openSync(path, 'w');
    writeSync(file, bytes);
    closeSync(file);
    if (size) truncateSync(path, size);
    files.push(path);
  };
  put('2001-01-01_00-00_sparse.clip', Buffer.from('SSLVCLIP'), 2 ** 33);
  put('2001-01-01_00-01_random.clip', random.bytes(100_000));
  put('2001-01-01_00-02_empty.clip', Buffer.alloc(0));
  put('2001-01-01_00-03_sparse.log.gz', Buffer.from([0x1f, 0x8b, 8, 0]), 2 ** 32);
  put('2001-01-01_00-04_bomb.log.gz', gzipSync(Buffer.concat([Buffer.from('SSL_LOG_FILE\0\0\0\x01'), Buffer.alloc(64 << 20)])));
  put('2001-01-01_00-05_random.log', random.bytes(100_000));
  put('2001-01-01_00-05_random.log.index.json', Buffer.from(`[${'[],'.repeat(1e6)}0]`));
  return files;
}

export default {
  name: 'files in the recordings\' folder',
  about: 'invalid, sparse or deeply compressed clips and logs: requests for lists, files, events and moments',
  async run({ ask, random, recordings, isOver, pause }) {
    const { admin } = await ask.cookies();
    const files = make(recordings, random);
    while (!isOver()) {
      for (const path of ['api/recordings', 'api/recordings/clips']) await ask('GET', path, { cookie: admin });
      for (const file of files) {
        const name = encodeURIComponent(file.slice(recordings.length + 1));
        await ask('GET', `api/recordings/logs/${name}/events`, { cookie: admin });
        await ask('GET', `api/recordings/logs/${name}/at?t=${random.number()}`, { cookie: admin });
        await ask('POST', `api/recordings/clips/${name}/compare`, { cookie: admin, body: {} });
      }
      writeFileSync(files[random.below(3)], random.bytes(random.below(10_000)));
      await pause(300);
    }
    for (const file of files) rmSync(file, { force: true });
  },
};
