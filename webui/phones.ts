// SPDX-License-Identifier: Apache-2.0
// Styles select a phone by "(max-width: 760px)" and everything else by "(min-width: 761px)". A phone held sideways is
// wider but needs the phone styles, too, so the build extends these conditions in all styles.
import type { Plugin } from 'postcss';

const PHONE = '(max-width: 760px)';
const SIDEWAYS = '(max-width: 960px) and (max-height: 480px)';

/** Extends a media rule's conditions so that a phone held sideways counts as a phone. */
export function phoneConditions(params: string): string {
  return params.split(',').map((part) => part.trim()).flatMap((part) => {
    if (part === PHONE) return [PHONE, SIDEWAYS];
    if (!part.includes('(min-width: 761px)')) return [part];
    return [`${part} and (min-height: 481px)`, part.replace('(min-width: 761px)', '(min-width: 961px)')];
  }).join(', ');
}

export const withPhonesHeldSideways: Plugin = {
  postcssPlugin: 'phones-held-sideways',
  OnceExit(root) {
    root.walkAtRules('media', (rule) => { rule.params = phoneConditions(rule.params); });
  },
};
