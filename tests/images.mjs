// SPDX-License-Identifier: Apache-2.0
// Checks docs/images: the screenshots of each page of the panel must be newer than its sources, and each image must be
// shown in README.md or docs. Exit code 1 if not.
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('..', import.meta.url));
const pages = join(root, 'webui/src/pages');
const filesIn = (folder, ending) => readdirSync(join(root, folder), { recursive: true }).filter((file) => ending.test(file)).sort().map((file) => join(folder, file));

/** For each page of the panel, the hash of its sources when its images were made. */
export const sumsFile = join(root, 'docs/images/pages.json');
export const readSums = () => JSON.parse(readFileSync(sumsFile, 'utf8'));

export function sumOf(page) {
  const sum = createHash('sha256');
  for (const file of filesIn(join('webui/src/pages', page), /(?<!\.test)\.(vue|ts|css)$/)) sum.update(readFileSync(join(root, file)));
  return sum.digest('hex').slice(0, 16);
}

function faults() {
  const sums = readSums();
  const outdated = readdirSync(pages).filter((page) => sums[page] !== sumOf(page));
  const shown = ['README.md', ...filesIn('docs', /\.md$/)].map((file) => readFileSync(join(root, file), 'utf8')).join('\n');
  return [
    ...(outdated.length ? [`docs/images: older than the panel's pages: ${outdated.join(', ')}. Run: ./run sheets ${outdated.join(' ')}`] : []),
    ...filesIn('docs/images', /\.(jpg|png)$/).filter((file) => !shown.includes(file.slice('docs/'.length))).map((file) => `${file}: no page shows it`),
  ];
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const found = faults();
  if (found.length) console.error(found.join('\n'));
  process.exitCode = found.length ? 1 : 0;
}
