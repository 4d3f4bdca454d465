// SPDX-License-Identifier: Apache-2.0

/**
 * Copies a text to the clipboard; false if the browser refuses. The newer navigator.clipboard needs HTTPS, which a
 * field's network rarely has.
 */
export function copyText(text: string): boolean {
  const field = document.createElement('textarea');
  field.value = text;
  field.className = 'vh';
  document.body.append(field);
  const focused = document.activeElement;
  field.select();
  const isCopied = document.execCommand('copy');
  field.remove();
  if (focused instanceof HTMLElement) focused.focus({ preventScroll: true });
  return isCopied;
}
