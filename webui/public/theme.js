// SPDX-License-Identifier: Apache-2.0
// Runs before the first paint, so that the page never flashes in the wrong theme.
(function () {
  var stored = null;
  try { stored = localStorage.getItem('theme'); } catch (e) { /* storage may be forbidden */ }
  var dark = stored ? stored === 'dark' : !matchMedia('(prefers-color-scheme: light)').matches;
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
})();
