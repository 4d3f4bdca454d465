// SPDX-License-Identifier: Apache-2.0
const MOST_SESSIONS = 256;
const opened = []; // cookies from all parts of a run: an address can open only about sixty a minute

export default {
  name: 'sessions and passwords',
  about: 'wrong passwords, and the maximum number of viewer sessions; the admin must stay signed in',
  async run({ ask, passwords, isOver, pause, check, random }) {
    const { admin } = await ask.cookies();
    for (let round = 0; !isOver(); ++round) {
      // Few wrong passwords: an address that has used up its attempts cannot open sessions either.
      const password = random.below(20) ? passwords.viewer : `guess ${random.below(1e6)}`;
      // Attempts from this computer are counted separately; most attempts here are from outside, to leave it some.
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
