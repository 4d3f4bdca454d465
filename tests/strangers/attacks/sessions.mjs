// SPDX-License-Identifier: Apache-2.0
export default {
  name: 'sessions and passwords',
  about: 'wrong passwords, and as many sessions with the viewers\' as there may be; the admin who signed in before stays so',
  async run({ ask, passwords, isOver, pause, check, random }) {
    const { admin } = await ask.cookies();
    while (!isOver()) {
      const password = random.below(3) ? passwords.viewer : `guess ${random.below(1e6)}`;
      await ask('POST', 'api/session', { body: { password }, outside: true });
      await ask('PATCH', 'api/settings', { body: [{ op: 'replace', path: '/site', value: 'Stolen' }], outside: true });
      await pause(100);
    }
    const { may } = (await ask('GET', 'api/session', { cookie: admin })).json;
    check(may === 'change', `the admin may ${may}`);
  },
};
