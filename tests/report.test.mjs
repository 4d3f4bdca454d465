// SPDX-License-Identifier: Apache-2.0
// The summary of ./run test, for passed, failed and skipped tests.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { afterEach, beforeEach, describe, it } from 'node:test';
import { fileURLToPath } from 'node:url';

const REPORT = fileURLToPath(new URL('report.mjs', import.meta.url));
let folder;
beforeEach(() => { folder = mkdtempSync(join(tmpdir(), 'ssl-visiond-report.')); });
afterEach(() => rmSync(folder, { recursive: true }));

function suite(name, exit, files) {
  mkdirSync(join(folder, name));
  writeFileSync(join(folder, name, 'suite.json'), JSON.stringify({ name, exit, seconds: 1, work_s: 1 }));
  for (const [file, text] of Object.entries(files)) writeFileSync(join(folder, name, file), text);
}
const report = () => {
  const { status, stdout } = spawnSync('node', [REPORT, folder], { encoding: 'utf8' });
  return { status, lines: stdout.trimEnd().split('\n') };
};
const gtest = (...cases) => `<testsuites><testsuite>${cases.join('')}</testsuite></testsuites>`;
const PASSED = '<testcase name="IsFound" status="run" result="completed" time="0.1" classname="Balls" />';
const SKIPPED = '<testcase name="OfAPhoto" status="run" result="skipped" time="0" classname="Photos"><skipped message="photos_test.cpp:12&#x0A;no photos in ../shared/data&#x0A;"/></testcase>';
const FAILED = '<testcase name="IsLost" status="run" result="completed" time="0.1" classname="Balls"><failure message="no"/></testcase>';

describe('the report', () => {
  it('counts and names tests that were skipped, with the reason, and not as passed', () => {
    suite('tests', 0, { 'unit.xml': gtest(PASSED, SKIPPED), 'api.jsonl': `${JSON.stringify({ name: 'api: waits', result: 'skipped', seconds: 0, why: 'no network' })}\n` });
    const { status, lines } = report();
    assert.equal(status, 0);
    assert.equal(lines.at(-1), '1 passed, 0 failed, 2 skipped');
    assert.ok(lines.includes('tests: Photos.OfAPhoto: no photos in ../shared/data'), lines.join('\n'));
    assert.ok(lines.includes('tests: api: waits: no network'), lines.join('\n'));
  });

  it('fails where one failed, and names it', () => {
    suite('tests', 1, { 'unit.xml': gtest(PASSED, FAILED) });
    const { status, lines } = report();
    assert.equal(status, 1);
    assert.equal(lines.at(-1), '1 passed, 1 failed, 0 skipped');
    assert.ok(lines.includes('FAILED: tests: Balls.IsLost'), lines.join('\n'));
  });

  it('counts a suite that broke before its tests could tell as one that failed', () => {
    suite('builds', 2, {});
    const { status, lines } = report();
    assert.equal(status, 1);
    assert.equal(lines.at(-1), '0 passed, 1 failed, 0 skipped');
  });

  it('names the part of a suite whose work has doubled, which is no failure: a slow computer needs as much', () => {
    suite('tests under sanitizers', 0, { 'unit.xml': gtest(PASSED), 'unit.work': '1\n', 'asan.unit.1.xml': gtest(PASSED), 'asan.unit.1.work': '5000\n', 'asan.unit.2.work': '5000\n' });
    const { status, lines } = report();
    assert.equal(status, 0);
    assert.ok(lines.some((line) => /10000\.0 .* tests under sanitizers, under AddressSanitizer and UBSan {2}OVER BUDGET$/.test(line)), lines.join('\n'));
    assert.equal(lines.at(-1), '2 passed, 0 failed, 0 skipped');
  });
});
