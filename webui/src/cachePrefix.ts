// SPDX-License-Identifier: Apache-2.0
/** Prefix of the panel's cache names: other pages of the same origin may have caches, too. */
export const CACHE_PREFIX = 'ssl-visiond-panel-';
