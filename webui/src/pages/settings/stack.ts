// SPDX-License-Identifier: Apache-2.0
// A camera's stack while it is rearranged.

export interface StackItem {
  name: string;
  /** Off: listed at its position here, but not in the stack. */
  isOn: boolean;
}

export const namesOf = (items: StackItem[]): string[] => items.filter(({ isOn }) => isOn).map(({ name }) => name);

/** The stack in use, and the missing stages of the usual stack at their positions, switched off. */
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

/** Inserts a new stage before the last active one: nothing may follow the sending stage. */
export function withAdded(items: StackItem[], name: string): StackItem[] {
  const last = items.findLastIndex(({ isOn }) => isOn);
  const at = last < 0 ? items.length : last;
  return [...items.slice(0, at), { name, isOn: true }, ...items.slice(at)];
}

/** The item that the service's error refers to; the service counts only active ones. */
export function itemAt(items: StackItem[], error: string): number | null {
  const place = /\/stack\/(\d+)/.exec(error)?.[1];
  if (place === undefined) return null;
  const on = items.flatMap(({ isOn }, index) => (isOn ? [index] : []));
  return on[Number(place)] ?? null;
}
