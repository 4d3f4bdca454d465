// SPDX-License-Identifier: Apache-2.0
// What lack of room shortens to "…" says all of it when a pointer rests on it.

/** The title given to a shortened text; one that has room again loses it. */
const GIVEN = 'fullText';

/** How far around what is pointed at the shortened text may be. */
const LEVELS = 3;

function shortenedAt(target: EventTarget | null): HTMLElement | null {
  let element = target instanceof HTMLElement ? target : null;
  for (let i = 0; element && i < LEVELS; i++, element = element.parentElement) {
    if (getComputedStyle(element).textOverflow === 'ellipsis') return element;
  }
  return null;
}

export function tellFullText(event: Event): void {
  const element = shortenedAt(event.target);
  if (!element) return;
  const isShort = element.scrollWidth > element.clientWidth;
  if (isShort && (GIVEN in element.dataset || !element.closest('[title]'))) {
    element.title = element.innerText.trim();
    element.dataset[GIVEN] = '';
  } else if (!isShort && GIVEN in element.dataset) {
    element.removeAttribute('title');
    delete element.dataset[GIVEN];
  }
}
