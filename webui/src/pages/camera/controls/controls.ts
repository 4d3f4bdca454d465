// SPDX-License-Identifier: Apache-2.0
// Known camera controls by name: GenICam (SFNC), V4L2 and IIDC.
import type { Control } from '../../../api/types';

/** Controls that an admin adjusts, in the order in which they are needed. Names in lower case without separators. */
const IMPORTANT: readonly RegExp[] = [
  /^(exposure(time(abs|raw|absolute)?|auto|mode|absolute)?|autoexposure|shutter(on|mode|value|absolute)?)$/,
  /^(auto)?gain(raw|abs|auto|automatic|selector|on|mode|value|absolute)?$/,
  /^(balance(ratio(abs|raw|selector)?|whiteauto)|whitebalance.*|(red|blue)balance)$/,
  /^gamma(enable|on|mode|value|absolute)?$/,
  /^(blacklevel(raw|abs)?|brightness(on|mode|value|absolute)?)$/,
  /^(acquisitionframerate(abs|enable)?|framerate(on|mode|value|absolute)?)$/,
  /^pixelformat$/,
  /^(width|height|offset[xy])$/,
  /^trigger(mode|source|software|on|value)?$/,
];

const plain = (name: string) => name.toLowerCase().replace(/[^a-z0-9]/g, '');
const rank = ({ name }: Control) => IMPORTANT.findIndex((pattern) => pattern.test(plain(name)));

/** Up to this many controls are all shown, for example those of a recording. */
const FEW = 10;

/** The important controls first, in the order above, then the others in the camera's order. */
export function sortControls(controls: readonly Control[]): { important: Control[]; others: Control[] } {
  if (controls.length <= FEW && !controls.some((control) => rank(control) >= 0)) return { important: [...controls], others: [] };
  const ranked = controls.map((control) => ({ control, at: rank(control) }));
  return {
    important: ranked.filter(({ at }) => at >= 0).sort((a, b) => a.at - b.at).map(({ control }) => control),
    others: ranked.filter(({ at }) => at < 0).map(({ control }) => control),
  };
}

/** "ExposureTimeAbs" as a title: "Exposure time abs". */
export function controlTitle({ name, title }: Control): string {
  if (title) return title;
  const words = name.replaceAll('_', ' ').replace(/([a-z0-9])([A-Z])/g, '$1 $2').replace(/([A-Z])([A-Z][a-z])/g, '$1 $2').split(' ').filter(Boolean);
  return words.map((word, i) => (i > 0 && !/^[A-Z]{2,}/.test(word) && word.length > 1 ? word.toLowerCase() : word)).join(' ');
}

/** Units that the standard fixes and some cameras omit. */
const STANDARD_UNITS: Record<string, string> = {
  exposuretime: 'us', exposuretimeabs: 'us', acquisitionframerate: 'Hz', acquisitionframerateabs: 'Hz',
  width: 'px', height: 'px', offsetx: 'px', offsety: 'px', sensorwidth: 'px', sensorheight: 'px', widthmax: 'px', heightmax: 'px', payloadsize: 'bytes',
};
const UNIT_SIGNS: Record<string, string> = { us: 'µs', deg: '°', C: '°C' };

export function unitOf({ name, unit }: Control): string {
  const own = unit || STANDARD_UNITS[plain(name)] || '';
  return UNIT_SIGNS[own] ?? own;
}

/** Changing these reopens the camera, so they are typed, not dragged. */
const LAYOUT = /^(width|height|offset[xy]|pixelformat|(binning|decimation).*|.*packetsize)$/;
export const isTyped = ({ name }: Control) => LAYOUT.test(plain(name));

/** A range over more than three decades gets a logarithmic slider. */
export const isWide = ({ min, max }: Control) => typeof min === 'number' && typeof max === 'number' && min > 0 && max / min > 1000;

export type Value = Control['value'];

/** Whether the camera's value is the saved one. Cameras round values by less than a step, or by 1e-4 of the value. */
export function isSame({ step }: Control, a: Value, b: Value): boolean {
  if (typeof a !== 'number' || typeof b !== 'number') return a === b;
  return Math.abs(a - b) <= Math.max((step ?? 0) * 0.99, Math.abs(b) * 1e-4);
}

export type Level = Control['level'];
const LEVELS: readonly Level[] = ['beginner', 'expert', 'guru'];

/** The controls up to `level` whose texts contain all search words. */
export function findControls(controls: readonly Control[], search: string, level: Level): Control[] {
  const wanted = search.toLowerCase().split(/\s+/).filter(Boolean);
  return controls.filter((control) => {
    const words = `${control.name} ${controlTitle(control)} ${control.category} ${control.help}`.toLowerCase();
    return LEVELS.indexOf(control.level) <= LEVELS.indexOf(level) && wanted.every((word) => words.includes(word));
  });
}

/** Controls by category, in the camera's order. */
export function byCategory(controls: readonly Control[]): { category: string; controls: Control[] }[] {
  const groups = new Map<string, Control[]>();
  for (const control of controls) groups.set(control.category, [...(groups.get(control.category) ?? []), control]);
  return [...groups].map(([category, list]) => ({ category: category.replace(/([a-z])([A-Z])/g, '$1 $2'), controls: list }));
}
