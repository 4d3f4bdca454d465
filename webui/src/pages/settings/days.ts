// SPDX-License-Identifier: Apache-2.0
import type { SettingsStep } from '../../api/types';

/** Groups steps by day, in the viewer's time zone. */
export function daysOf(steps: SettingsStep[], now = new Date()): { title: string; steps: SettingsStep[] }[] {
  const days: { title: string; steps: SettingsStep[] }[] = [];
  for (const step of steps) {
    const title = dayTitle(new Date(step.time * 1000), now);
    if (days.at(-1)?.title !== title) days.push({ title, steps: [] });
    days.at(-1)!.steps.push(step);
  }
  return days;
}

function dayTitle(at: Date, now: Date): string {
  const daysAgo = (days: number) => new Date(now.getFullYear(), now.getMonth(), now.getDate() - days).toDateString();
  if (at.toDateString() === daysAgo(0)) return 'Today';
  if (at.toDateString() === daysAgo(1)) return 'Yesterday';
  const two = (value: number) => String(value).padStart(2, '0');
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())}`;
}

export const whoOf = (steps: SettingsStep[]): string[] => [...new Set(steps.map(({ who }) => who))].sort();
