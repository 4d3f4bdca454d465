// SPDX-License-Identifier: Apache-2.0
// Times of day, as the reader's clock has them.

const two = (value: number) => String(value).padStart(2, '0');

/** "14:02:31", or "14:02", of Unix seconds. */
export function clock(unix_s: number, withSeconds = true): string {
  const date = new Date(unix_s * 1000);
  return `${two(date.getHours())}:${two(date.getMinutes())}${withSeconds ? `:${two(date.getSeconds())}` : ''}`;
}

/** "14:02:31.204" of Unix seconds. */
export function clockMs(unix_s: number): string {
  const ms = Math.floor(Math.round(unix_s * 1e3) % 1000);
  return `${clock(Math.floor(Math.round(unix_s * 1e3) / 1000))}.${String(ms).padStart(3, '0')}`;
}
