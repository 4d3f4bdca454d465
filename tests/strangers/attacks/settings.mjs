// SPDX-License-Identifier: Apache-2.0

const BODIES = [
  (random) => Array.from({ length: 20 }, () => ({ op: 'copy', from: '', path: `/x${random.below(9)}` })),
  () => [{ op: 'add', path: '/x', value: [] }, ...Array.from({ length: 22 }, () => ({ op: 'copy', from: '', path: '/x/-' }))],
  () => [{ op: 'replace', path: '/site', value: 'S'.repeat(900_000) }],
  () => [{ op: 'replace', path: '/cameras/0/mask/exclude', value: Array.from({ length: 30_000 }, () => ({ points: [[0, 0], [1, 1], [1, 0]] })) }],
  () => `[${'[],'.repeat(340_000)}0]`,
  () => `[${'"",'.repeat(340_000)}0]`,
  () => `[{"op":"add","path":"/site","value":[${'{},'.repeat(340_000)}0]}]`,
  (random) => random.bytes(100_000),
];

export default {
  name: 'bodies that fill memory',
  about: 'an admin\'s browser sends patches that copy themselves, nest deeply, are long or need much memory: checked, not saved',
  async run({ ask, random, isOver, pause, check }) {
    const { admin } = await ask.cookies();
    while (!isOver()) {
      const body = random.pick(BODIES)(random);
      const { status, text } = await ask('POST', 'api/settings/check', { body, cookie: admin });
      check([400, 422].includes(status), `a bad patch is answered with ${status}: ${text.slice(0, 200)}`);
      await ask('POST', 'api/settings/check', { body, outside: true });
      await pause(100);
    }
  },
};
