// SPDX-License-Identifier: Apache-2.0
/** Begins the name of each cache of the panel: other pages of the same origin may have caches, too. */
export const CACHE_PREFIX = 'ssl-visiond-panel-';
