// SPDX-License-Identifier: Apache-2.0
// Reporter for `node --test`: writes a line of JSON per test for tests/report.mjs: {name, result, seconds, why}.
const names = [];

export default async function* lines(events) {
  for await (const { type, data } of events) {
    if (type === 'test:start') names[data.nesting] = data.name;
    if (type !== 'test:pass' && type !== 'test:fail') continue;
    // Groups and files are not tests themselves, but the tests of a skipped group are not reported: its group is.
    const isGroup = data.details?.type === 'suite' || /\.mjs$/.test(data.name);
    const skipped = data.skip !== undefined && data.skip !== false;
    const onlyWithin = type === 'test:pass' || data.details.error?.failureType === 'subtestsFailed';
    if (isGroup && !skipped && onlyWithin) continue;
    yield `${JSON.stringify({
      name: [...names.slice(0, data.nesting), data.name].join(': '),
      result: type === 'test:fail' ? 'failed' : skipped ? 'skipped' : 'passed',
      seconds: (data.details?.duration_ms ?? 0) / 1000,
      why: skipped ? String(data.skip) : undefined,
      group: isGroup,
    })}\n`;
  }
}
