// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from 'node:fs';
import vue from '@vitejs/plugin-vue';
import { defineConfig } from 'vitest/config';
import { panelFiles } from './panelFiles';
import { withPhonesHeldSideways } from './phones';

// The daemon that `npm run dev` talks to.
const daemon = process.env.SSL_VISIOND ?? 'http://127.0.0.1:8090';

export default defineConfig({
  base: './',
  plugins: [
    vue(),
    {
      name: 'openapi',
      generateBundle() {
        this.emitFile({ type: 'asset', fileName: 'api/openapi.json', source: readFileSync('../docs/openapi.json') });
      },
    },
    panelFiles(),
  ],
  css: { postcss: { plugins: [withPhonesHeldSideways] } },
  build: {
    target: 'es2022',
    // A strict content security policy forbids data: fonts and scripts, so no asset is inlined.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
  },
  // Tests read files of the service in ../daemon.
  server: { proxy: { '/api': { target: daemon, ws: true } }, fs: { allow: ['..'] } },
  preview: { proxy: { '/api': { target: daemon, ws: true } } },
  // One process for all tests: starting one per file took six times as long. The timeouts equal PATIENCE_MS in
  // ../tests/e2e/service.mjs.
  test: { include: ['src/**/*.test.ts'], isolate: false, testTimeout: 300_000, hookTimeout: 300_000 },
});
