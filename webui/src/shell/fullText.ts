// SPDX-License-Identifier: Apache-2.0
// Shows the full text of an element that is shortened to "…" as its tooltip.

/** Marks titles that were set here; they are removed when the text fits again. */
const GIVEN = 'fullText';

/** How many ancestors of the pointed element are checked. */
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
