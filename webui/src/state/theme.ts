// SPDX-License-Identifier: Apache-2.0
// Dark or light: the user's choice if there is one, else the system's. public/theme.js sets it before the first paint.
import { ref } from 'vue';

export type Theme = 'dark' | 'light';

const KEY = 'theme';
const system = matchMedia('(prefers-color-scheme: light)');

function stored(): Theme | null {
  try {
    const value = localStorage.getItem(KEY);
    return value === 'dark' || value === 'light' ? value : null;
  } catch {
    return null;
  }
}

export const theme = ref<Theme>(stored() ?? (system.matches ? 'light' : 'dark'));

function apply(next: Theme): void {
  theme.value = next;
  document.documentElement.dataset.theme = next;
  const colour = getComputedStyle(document.documentElement).getPropertyValue('--s-1').trim();
  document.querySelector('meta[name="theme-color"]')?.setAttribute('content', colour);
}

export function followTheme(): void {
  apply(theme.value);
  system.addEventListener('change', () => {
    if (!stored()) apply(system.matches ? 'light' : 'dark');
  });
}

export function toggleTheme(): void {
  const next = theme.value === 'dark' ? 'light' : 'dark';
  apply(next);
  try {
    localStorage.setItem(KEY, next);
  } catch {
    // Without storage the choice lasts as long as the page.
  }
}
