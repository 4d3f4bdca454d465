// SPDX-License-Identifier: Apache-2.0
// Prints the summary of ./run test: skipped tests with reasons, the slowest tests, the CPU time of each suite compared
// with its budget, and as last line 'N passed, N failed, N skipped'.
//
//   node tests/report.mjs FOLDER
//
// FOLDER has a folder for each suite, with `suite.json` {name, exit, seconds, work_s} and the files of its tests: *.xml
// of gtest and ctest, *.jsonl of tests/node_reporter.mjs, vitest.json, *.work of tests/entry.sh. Exit code: 1 if a test
// failed. A suite that needs more than `factor` times its budget (tests/budget.json) is marked.
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const SLOWEST = 10;
const SANITIZERS = { asan: 'under AddressSanitizer and UBSan', tsan: 'under ThreadSanitizer' };
const ENTITIES = { lt: '<', gt: '>', quot: '"', apos: "'", amp: '&', '#x0A': '\n', '#x0a': '\n' };
const plain = (text) => text.replace(/&([a-z]+|#x0A);/gi, (all, name) => ENTITIES[name] ?? all);
const attributes = (text) => Object.fromEntries([...text.matchAll(/([\w-]+)="([^"]*)"/g)].map(([, key, value]) => [key, plain(value)]));

/** The tests in a JUnit file as written by gtest and ctest. */
function testsOfXml(text) {
  return [...text.matchAll(/<testcase\s([^>]*?)(\/>|>([\s\S]*?)<\/testcase>)/g)].map(([, head, , inside = '']) => {
    const { name, classname, time, result, status } = attributes(head);
    const skipped = result === 'skipped' || ['notrun', 'disabled'].includes(status) || /<skipped/.test(inside);
    const failed = /<failure/.test(inside) || status === 'fail';
    // The lines that name a place in a source file are not part of the reason.
    const why = plain(/<skipped[^>]*?message="([^"]*)"/.exec(inside)?.[1] ?? '').split('\n').filter((line) => !/\.cpp:\d+$/.test(line)).join(' ').trim();
    return {
      name: classname && classname !== name ? `${classname}.${name}` : name,
      result: failed ? 'failed' : skipped ? 'skipped' : 'passed', seconds: Number(time ?? 0), why,
    };
  });
}

function testsOfVitest(text) {
  return JSON.parse(text).testResults.flatMap(({ assertionResults }) => assertionResults.map(({ fullName, status, duration = 0 }) => ({
    name: fullName, result: { passed: 'passed', failed: 'failed' }[status] ?? 'skipped', seconds: duration / 1000,
  })));
}

/** All tests of a suite's folder. A ctest entry without a result file counts as one test. */
function testsOf(folder) {
  const files = readdirSync(folder);
  const read = (file) => readFileSync(join(folder, file), 'utf8');
  const tests = files.flatMap((file) => {
    if (file === 'ctest.xml' || file === 'suite.json') return [];
    if (file.endsWith('.xml')) return testsOfXml(read(file));
    if (file.endsWith('.jsonl')) return read(file).split('\n').filter(Boolean).map((line) => JSON.parse(line));
    return file === 'vitest.json' ? testsOfVitest(read(file)) : [];
  });
  if (!files.includes('ctest.xml')) return tests;
  for (const entry of testsOfXml(read('ctest.xml'))) {
    const told = files.find((file) => file === `${entry.name}.xml` || file === `${entry.name}.jsonl`);
    const failedInside = told && read(told).match(/<failure|"result":"failed"/);
    // An entry may have failed without a failed test in its file, if it ended early.
    if (!told || (entry.result === 'failed' && !failedInside)) tests.push(entry);
  }
  return tests;
}

const folder = process.argv[2];
const suites = readdirSync(folder).filter((name) => existsSync(join(folder, name, 'suite.json'))).sort().map((name) => {
  const suite = JSON.parse(readFileSync(join(folder, name, 'suite.json'), 'utf8'));
  const tests = testsOf(join(folder, name)).map((test) => ({ ...test, suite: suite.name }));
  // A suite without tests, or one that failed although no test did, counts as one test.
  const result = suite.exit === 0 ? 'passed' : suite.exit === 77 ? 'skipped' : 'failed';
  const broke = result === 'failed' && !tests.some((test) => test.result === 'failed');
  if (tests.length === 0 || broke) tests.push({ name: suite.name, suite: suite.name, result, seconds: suite.seconds });
  return { ...suite, folder: name, tests };
});
const tests = suites.flatMap((suite) => suite.tests);
const withResult = (wanted) => tests.filter(({ result }) => result === wanted);
const seconds = (value) => value.toFixed(1).padStart(8);

const say = (title) => console.log(`\n== ${title}`);
if (withResult('skipped').length) {
  say('skipped');
  for (const { suite, name, why } of withResult('skipped')) console.log(`${suite}: ${name}${why ? `: ${why}` : ''}`);
}
say(`the slowest of ${tests.length} tests`);
for (const test of tests.filter(({ group }) => !group).sort((a, b) => b.seconds - a.seconds).slice(0, SLOWEST)) {
  console.log(`${seconds(test.seconds)} s  ${test.suite}: ${test.name}`);
}

// Work is CPU time, which hardly depends on other load. A slow machine needs more, so this is not a failure.
const budget = JSON.parse(readFileSync(fileURLToPath(new URL('budget.json', import.meta.url)), 'utf8'));
say('suites: wall time, CPU time, budget (s)');
function row(name, seconds_passed, work_s) {
  const own = budget.work_s[name];
  console.log(`${seconds_passed === undefined ? '       -' : seconds(seconds_passed)} ${seconds(work_s)} ${own === undefined ? '       -' : seconds(own)}  ${name}${work_s > budget.factor * own ? '  OVER BUDGET' : ''}`);
}
for (const suite of suites) {
  row(suite.name, suite.seconds, suite.work_s);
  // The parts of a suite that run in parallel; names of sanitizer tests begin with the sanitizer's prefix.
  const parts = new Map();
  for (const file of readdirSync(join(folder, suite.folder)).filter((name) => name.endsWith('.work'))) {
    const part = SANITIZERS[file.split('.')[0]] ?? 'as shipped';
    parts.set(part, (parts.get(part) ?? 0) + Number(readFileSync(join(folder, suite.folder, file), 'utf8')));
  }
  for (const [part, work_s] of [...parts].sort()) row(`${suite.name}, ${part}`, undefined, work_s);
}

if (withResult('failed').length) {
  say('failed');
  for (const { suite, name } of withResult('failed')) console.log(`FAILED: ${suite}: ${name}`);
}
console.log();
const failed = withResult('failed').length;
console.log(`${withResult('passed').length} passed, ${failed} failed, ${withResult('skipped').length} skipped`);
process.exitCode = failed ? 1 : 0;
