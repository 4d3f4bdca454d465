// SPDX-License-Identifier: Apache-2.0

const grouped = new Intl.NumberFormat('en', { maximumFractionDigits: 0, useGrouping: true });
const THIN_SPACE = '\u2009';
const MINUS = '−';

/** A whole number with thin spaces between thousands. */
export function figure(value: number): string {
  return grouped.format(value).replace(/,/g, THIN_SPACE).replace('-', MINUS);
}

/** A latency in milliseconds with at most three figures. */
export function latencyMs(value: number): string {
  return value < 9.995 ? value.toFixed(2) : value < 99.95 ? value.toFixed(1) : value.toFixed(0);
}

/** A stage's time in µs, or in ms from 10 ms. */
export function stageTime(us: number): { value: string; unit: string } {
  if (us >= 9999.5) return { value: latencyMs(us / 1000), unit: 'ms' };
  return { value: us < 9.95 ? us.toFixed(1) : figure(us), unit: 'µs' };
}

/** A number with a fixed number of decimals and a true minus sign. */
export function decimal(value: number, decimals: number): string {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', MINUS);
}

export function plural(count: number, word: string): string {
  return `${figure(count)} ${word}${count === 1 ? '' : 's'}`;
}

/** "8 s", "4 min", "2 h 5 min", "3 d 4 h" */
export function duration(seconds: number): string {
  const s = Math.max(0, Math.floor(seconds));
  if (s < 60) return `${s} s`;
  const min = Math.floor(s / 60);
  if (min < 60) return `${min} min`;
  const h = Math.floor(min / 60);
  return h < 24 ? `${h} h ${min % 60} min` : `${Math.floor(h / 24)} d ${h % 24} h`;
}

/** "under 1 s", "8 s", "2 min 13 s", "2 h 5 min", "3 d 4 h" */
export function exactDuration(seconds: number): string {
  const s = Math.max(0, Math.floor(seconds));
  if (s < 1) return 'under 1 s';
  return s < 60 || s >= 3600 ? duration(s) : `${Math.floor(s / 60)} min ${s % 60} s`;
}

const twoFigures = (value: number) => String(value).padStart(2, '0');

/** "14:02:31", or "14:02", for a Unix time in seconds, in the viewer's time zone. */
export function timeOfDay(unixSeconds: number, withSeconds = true): string {
  const at = new Date(unixSeconds * 1000);
  return [at.getHours(), at.getMinutes(), ...(withSeconds ? [at.getSeconds()] : [])].map(twoFigures).join(':');
}

/** "14:02:31.204" for a Unix time in seconds, in the viewer's time zone. */
export function timeOfDayMs(unixSeconds: number): string {
  const ms = Math.round(unixSeconds * 1000);
  return `${timeOfDay(Math.floor(ms / 1000))}.${String(ms % 1000).padStart(3, '0')}`;
}

/** "14:02:31" for a Unix time in seconds, in the viewer's time zone; with the date unless it is today. */
export function clockTime(unixSeconds: number, today = new Date()): string {
  const at = new Date(unixSeconds * 1000);
  const time = timeOfDay(unixSeconds);
  return at.toDateString() === today.toDateString() ? time : `${at.getFullYear()}-${twoFigures(at.getMonth() + 1)}-${twoFigures(at.getDate())} ${time}`;
}
