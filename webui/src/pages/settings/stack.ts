// SPDX-License-Identifier: Apache-2.0
// A camera's stack while it is rearranged.

export interface StackItem {
  name: string;
  /** Off: kept at its place here, not in the stack. */
  isOn: boolean;
}

export const namesOf = (items: StackItem[]): string[] => items.filter(({ isOn }) => isOn).map(({ name }) => name);

/** The stack in use, with the stages of the usual stack that it lacks at their places, switched off. */
export function itemsOf(stack: string[], usual: string[]): StackItem[] {
  const items = stack.map((name): StackItem => ({ name, isOn: true }));
  usual.forEach((name, i) => {
    if (items.some((item) => item.name === name)) return;
    const before = usual.slice(0, i).findLast((one) => items.some((item) => item.name === one));
    items.splice(before === undefined ? 0 : items.findLastIndex((item) => item.name === before) + 1, 0, { name, isOn: false });
  });
  return items;
}

export function moved<T>(list: T[], from: number, to: number): T[] {
  const rest = list.filter((_, index) => index !== from);
  rest.splice(Math.max(0, to), 0, list[from]!);
  return rest;
}

/** A new stage goes before the last one that is on: nothing comes after what is sent. */
export function withAdded(items: StackItem[], name: string): StackItem[] {
  const last = items.findLastIndex(({ isOn }) => isOn);
  const at = last < 0 ? items.length : last;
  return [...items.slice(0, at), { name, isOn: true }, ...items.slice(at)];
}

/** Which item the service's refusal is about: it counts only those that are on. */
export function itemAt(items: StackItem[], error: string): number | null {
  const place = /\/stack\/(\d+)/.exec(error)?.[1];
  if (place === undefined) return null;
  const on = items.flatMap(({ isOn }, index) => (isOn ? [index] : []));
  return on[Number(place)] ?? null;
}
