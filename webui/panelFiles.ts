// SPDX-License-Identifier: Apache-2.0
// The last build step: writes the service worker with the list of all files, and a .gz copy of each text file. The
// service sends these copies unchanged.
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { transformWithEsbuild, type Plugin } from 'vite';
import { CACHE_PREFIX } from './src/cachePrefix';

const PACKED = /\.(html|js|css|svg|webmanifest)$/;
/** Not cached by the service worker: the API description, which the service generates, the worker, packed copies. */
const LEFT_OUT = /^api\/|^sw\.js$|\.gz$/;

export function panelFiles(): Plugin {
  return {
    name: 'panel-files',
    apply: 'build',
    async writeBundle({ dir }) {
      const list = () => readdirSync(dir!, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile())
        .map((entry) => join(entry.parentPath ?? entry.path, entry.name).slice(dir!.length + 1).replaceAll('\\', '/')).sort();
      const kept = list().filter((file) => !LEFT_OUT.test(file));
      const version = createHash('sha256');
      for (const file of kept) version.update(file).update(readFileSync(join(dir!, file)));
      const source = new URL('sw/sw.ts', import.meta.url);
      const { code } = await transformWithEsbuild(readFileSync(source, 'utf8'), 'sw.ts', {
        format: 'iife', minify: true, sourcemap: false, target: 'es2022',
        define: {
          PREFIX: JSON.stringify(CACHE_PREFIX),
          FILES: JSON.stringify(kept.map((file) => (file === 'index.html' ? './' : file))),
          VERSION: JSON.stringify(version.digest('hex').slice(0, 16)),
        },
      });
      writeFileSync(join(dir!, 'sw.js'), code);
      for (const file of list().filter((name) => PACKED.test(name))) {
        writeFileSync(join(dir!, `${file}.gz`), gzipSync(readFileSync(join(dir!, file)), { level: 9 }));
      }
    },
  };
}
