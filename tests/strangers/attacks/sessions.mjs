// SPDX-License-Identifier: Apache-2.0
const MOST_SESSIONS = 256;
const opened = []; // cookies, of all parts of a run: a minute allows for sixty or so of an address

export default {
  name: 'sessions and passwords',
  about: 'wrong passwords, and as many sessions with the viewers\' as there may be; the admin who signed in before stays so',
  async run({ ask, passwords, isOver, pause, check, random }) {
    const { admin } = await ask.cookies();
    for (let round = 0; !isOver(); ++round) {
      // Wrong ones are few: an address that has no tries left cannot open sessions either.
      const password = random.below(20) ? passwords.viewer : `guess ${random.below(1e6)}`;
      // This computer's own tries are counted apart. Some of them are left for others that sign in here.
      const { status, headers } = await ask('POST', 'api/session', { body: { password }, outside: round % 10 > 0 });
      if (status === 200) opened.push(headers['set-cookie'][0].split(';')[0]);
      await ask('PATCH', 'api/settings', { body: [{ op: 'replace', path: '/site', value: 'Stolen' }], outside: true });
      await pause(200);
    }
    const { may } = (await ask('GET', 'api/session', { cookie: admin })).json;
    check(may === 'change', `the admin may ${may}`);
    let left = 0;
    for (const cookie of opened) left += (await ask('GET', 'api/session', { cookie })).json?.signed_in ? 1 : 0;
    check(left <= MOST_SESSIONS, `${left} sessions of viewers are open`);
    check(left >= Math.min(opened.length, MOST_SESSIONS / 2), `of ${opened.length} sessions only ${left} are open`);
  },
};
