// SPDX-License-Identifier: Apache-2.0
// Finds visible layout faults of a page by measuring: text or controls that are cut, unreachable or overlapping, touch
// targets that are too small, images too small to see robots in.

/** Minimum side of a touch target, in CSS pixels (WCAG 2.5.5). */
export const FINGER_PX = 44;

/**
 * Minimum of the shorter side of a page's main camera image, relative to the shorter side of the window. At 0.4, on the
 * smallest phone, half a field of 4.5 m is 144 px wide: a robot of 180 mm is 6 px, which can still be tapped.
 */
export const LEAST_IMAGE = 0.4;

/**
 * Intended exceptions: {kind, selector, why}. Each applies to elements that match the selector or are inside one that
 * does; for an overlap, to either element. Add exceptions for new pages here, with a reason.
 */
export const exceptions = [
  { kind: 'overlap', selector: '.tile .open', why: 'the whole image leads to its camera, and its name stands on it' },
  { kind: 'overlap', selector: '[data-testid="robot-target"], [data-testid="point"], .handle, .robot-targets', why: 'lies where the image has the thing' },
  { kind: 'small', selector: '[data-testid="robot-target"]', why: 'as large as the robot in the image; zooming enlarges it' },
  { kind: 'cut', selector: '.picture .box', why: 'marks of what is partly outside the image' },
  { kind: 'overlap', selector: '.picture .box', why: 'marks lie where the image has the thing' },
  { kind: 'overlap', selector: 'svg', why: 'drawings: labels of robots that stand close, dimensions on lines' },
  { kind: 'cut', selector: 'svg', why: 'drawings: a robot may stand beyond the edge' },
];

/**
 * Runs in the browser: returns all faults currently visible, as {kind, at, what}.
 * kind: wide, cut, outside, overlap, small, image.
 */
function look({ isTouch, exceptions, finger, leastImage }) {
  const faults = [];
  const width = document.documentElement.clientWidth;
  const height = window.innerHeight;
  const styles = new Map();
  const styleOf = (element) => {
    if (!styles.has(element)) styles.set(element, getComputedStyle(element));
    return styles.get(element);
  };

  // ---- description of an element

  const shorten = (text, length = 40) => {
    const words = text.replace(/\s+/g, ' ').trim();
    return words.length > length ? `${words.slice(0, length)}…` : words;
  };
  function nameOf(element) {
    const { testid } = element.dataset ?? {};
    const classes = [...element.classList].slice(0, 3).map((one) => `.${one}`).join('');
    const label = element.getAttribute('aria-label') ?? element.textContent;
    return `${element.localName}${testid ? `[data-testid="${testid}"]` : classes}${label?.trim() ? ` "${shorten(label)}"` : ''}`;
  }
  function placeOf(element) {
    const around = element.parentElement?.closest('[data-testid], section, header, nav, article, dialog');
    if (!around || around.localName === 'main') return nameOf(element);
    const label = around.getAttribute('aria-label') ?? document.getElementById(around.getAttribute('aria-labelledby') ?? '')?.textContent;
    const { testid } = around.dataset;
    return `${around.localName}${testid ? `[data-testid="${testid}"]` : label ? ` (${shorten(label)})` : `.${around.classList[0] ?? ''}`} > ${nameOf(element)}`;
  }
  const isMeant = (kind, ...elements) => exceptions.some((one) => one.kind === kind && elements.some((element) => element.closest(one.selector)));
  const tell = (kind, element, what, other) => {
    if (!isMeant(kind, element, ...(other ? [other] : []))) faults.push({ kind, at: placeOf(element), what });
  };

  // ---- visibility and clipping

  const hiddenOnes = new Map();
  /** For screen readers only, or not rendered. */
  function isHidden(element) {
    if (!element || element === document.documentElement) return false;
    if (!hiddenOnes.has(element)) {
      hiddenOnes.set(element, styleOf(element).clipPath.startsWith('inset(50%') || isHidden(element.parentElement));
    }
    return hiddenOnes.get(element);
  }
  const isShown = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) && !isHidden(element);
  const contains = (style) => /paint|strict|content/.test(style.contain);
  const holdsFixed = (style) => style.transform !== 'none' || style.filter !== 'none' || /paint|layout|strict|content/.test(style.contain);
  /** The nearest ancestor that may clip this element; null: only the window does. */
  function around(element) {
    const { position } = styleOf(element);
    let next = element.parentElement;
    if (position === 'fixed') while (next && !holdsFixed(styleOf(next))) next = next.parentElement;
    if (position === 'absolute') while (next && styleOf(next).position === 'static' && !holdsFixed(styleOf(next))) next = next.parentElement;
    return next === document.documentElement || next === document.body ? null : next;
  }
  function insideOf(element) {
    const box = element.getBoundingClientRect();
    return {
      left: box.left + element.clientLeft, top: box.top + element.clientTop,
      right: box.left + element.clientLeft + element.clientWidth, bottom: box.top + element.clientTop + element.clientHeight,
    };
  }
  const plain = ({ left, top, right, bottom }) => ({ left, top, right, bottom });
  const scrolls = (value) => value === 'auto' || value === 'scroll';
  const cuts = (value) => value === 'hidden' || value === 'clip';
  /**
   * Follows a box outwards to the window. Returns its currently visible part, the element that scrolls it, and the
   * fault if a part is clipped that scrolling cannot reveal.
   */
  function follow(start, box, isText) {
    let rect = plain(box);
    let seen = plain(box);
    /** The part of a shortened text that remains visible. */
    let kept = plain(box);
    let scroller = null;
    let isFixed = false;
    const slackX = 1.5;
    const slackY = isText ? Math.max(1.5, 0.16 * (box.bottom - box.top)) : 1.5;
    let fault = null;
    /** A text is also clipped by its own element. */
    for (let element = isText ? start : around(start), from = start; ; from = element, element = around(element)) {
      if (['fixed', 'sticky'].includes(styleOf(from).position)) { isFixed ||= styleOf(from).position === 'fixed'; scroller ??= from; }
      if (!element) break;
      const style = styleOf(element);
      if (style.display === 'contents' || style.display === 'inline') continue;
      const inside = insideOf(element);
      for (const [low, high, overflow, slack] of [['left', 'right', style.overflowX, slackX], ['top', 'bottom', style.overflowY, slackY]]) {
        const isCut = cuts(overflow) || (contains(style) && !scrolls(overflow));
        if (!isCut && !scrolls(overflow)) continue;
        seen = { ...seen, [low]: Math.max(seen[low], inside[low]), [high]: Math.min(seen[high], inside[high]) };
        if (isCut) {
          const by = Math.max(inside[low] - rect[low], rect[high] - inside[high]);
          if (by > slack) {
            const isShort = low === 'left' ? style.textOverflow === 'ellipsis' : style.webkitLineClamp !== 'none';
            // The panel adds a title to a shortened text when the pointer enters it.
            if (isShort && !element.closest('[title]')) element.dispatchEvent(new PointerEvent('pointerover', { bubbles: true }));
            if (isShort) kept = { ...kept, [low]: Math.max(kept[low], inside[low]), [high]: Math.min(kept[high], inside[high]) };
            if (isShort && element.closest('[title]')) rect = { ...rect, [low]: Math.max(rect[low], inside[low]), [high]: Math.min(rect[high], inside[high]) };
            else fault ??= { element, by: Math.round(by), axis: low === 'left' ? 'x' : 'y', isShort };
          }
        } else {
          scroller ??= element;
          const scrolled = low === 'left' ? element.scrollLeft : element.scrollTop;
          const before = inside[low] - (rect[low] + scrolled);
          // Right to left or end-aligned: scrolling cannot reveal content before the start.
          if (before > slack && styleOf(from).position !== 'sticky') fault ??= { element, by: Math.round(before), axis: low === 'left' ? 'x' : 'y' };
          rect = { ...rect, [low]: inside[low], [high]: inside[high] };
        }
      }
    }
    const [right, bottom] = isFixed ? [width, height] : [width, Infinity];
    const [x, y] = isFixed ? [0, 0] : [scrollX, scrollY];
    const out = Math.max(-(rect.left + x), rect.right + x - right, -(rect.top + y), rect.bottom + y - bottom);
    if (out > 1.5 && !fault) fault = { out: Math.round(out) };
    seen = { left: Math.max(seen.left, 0), top: Math.max(seen.top, 0), right: Math.min(seen.right, width), bottom: Math.min(seen.bottom, height) };
    return { seen, kept, scroller, fault };
  }
  function tellCut(element, { fault }, what) {
    if (!fault) return;
    if (fault.out) tell('outside', element, `${what} is ${fault.out} px outside the window, and no scrolling leads there`);
    else tell('cut', element, `${what} is cut by ${fault.by} px ${fault.axis === 'x' ? 'sideways' : 'in height'} by ${nameOf(fault.element)}${fault.isShort ? ', shortened without a title that says all' : ''}`);
  }

  // ---- controls and texts of the page

  const CONTROLS = 'a[href], button, input, select, textarea, summary, [role="button"], [role="slider"], [role="tab"], [role="checkbox"], [role="switch"], [role="radio"]';
  // An open modal dialog hides everything else.
  const all = document.querySelector('dialog:modal') ?? document.body;
  // A link in a sentence has one box per line.
  const boxesOf = (element) => (styleOf(element).display === 'inline' ? [...element.getClientRects()] : [element.getBoundingClientRect()]);
  const controls = [...all.querySelectorAll(CONTROLS)].filter((element) => isShown(element) && element.type !== 'hidden')
    .flatMap((element) => boxesOf(element).map((box) => ({ element, box, isControl: true })))
    .filter(({ box }) => box.width > 1 && box.height > 1);
  const texts = [];
  const walker = document.createTreeWalker(all, NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    if (!node.data.trim() || element.closest('script, style, noscript, select, textarea') || !isShown(element)) continue;
    range.selectNodeContents(node);
    for (const box of range.getClientRects()) {
      if (box.width > 1 && box.height > 1) texts.push({ element, box, isControl: false, text: node.data, node });
    }
  }

  // ---- the document itself

  const wide = Math.max(document.documentElement.scrollWidth, document.body.scrollWidth) - width;
  if (wide > 0) faults.push({ kind: 'wide', at: 'document', what: `scrolls sideways by ${wide} px` });

  // ---- clipped or unreachable

  for (const item of [...controls, ...texts]) {
    item.way = follow(item.element, item.box, !item.isControl);
    tellCut(item.element, item.way, item.isControl ? 'it' : `its text "${shorten(item.text)}"`);
  }
  const ruler = document.createElement('canvas').getContext('2d');
  for (const { element } of controls) {
    const isField = element.localName === 'input' && !['checkbox', 'radio', 'range', 'file', 'color'].includes(element.type);
    if (!isField && element.localName !== 'select') continue;
    const style = styleOf(element);
    ruler.font = style.font;
    const text = element.localName === 'select' ? element.selectedOptions[0]?.text ?? '' : element.type === 'number' ? element.value : element.placeholder;
    const room = element.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
    const by = Math.round(ruler.measureText(text).width - room);
    if (by > 1 && !element.closest('[title]')) tell('cut', element, `its text "${shorten(text)}" is ${by} px wider than its field`);
  }
  const scrollers = new Set([...controls, ...texts].map(({ way }) => way.scroller).filter(Boolean));
  for (const element of scrollers) {
    const style = styleOf(element);
    if (scrolls(style.overflowY) && element.scrollHeight > element.clientHeight + 1 && element.clientHeight < 72) tell('cut', element, `only ${element.clientHeight} px of ${element.scrollHeight} px are seen of what scrolls in it`);
    if (scrolls(style.overflowX) && element.scrollWidth > element.clientWidth + 1 && element.clientWidth < 120) tell('cut', element, `only ${element.clientWidth} px of ${element.scrollWidth} px are seen of what scrolls in it`);
  }

  // ---- overlapping

  const isRelated = (a, b) => a.contains(b) || b.contains(a);
  const labelOf = (element) => element.closest('label');
  const isSameLabel = (a, b) => labelOf(a) !== null && (labelOf(a) === labelOf(b) || labelOf(a).control === b || labelOf(b)?.control === a);
  /** A menu opened by a button covers what is below it, like a dialog. */
  const opened = [...document.querySelectorAll('[aria-expanded="true"][aria-controls]')].map((button) => document.getElementById(button.getAttribute('aria-controls'))).filter(Boolean);
  const isMenu = (element) => opened.some((menu) => menu.contains(element) && ['absolute', 'fixed'].includes(styleOf(menu).position));
  const isOpaque = (element) => /^rgb\(|^color\([^/]*\)$/.test(styleOf(element).backgroundColor) && styleOf(element).opacity === '1';
  /** The opaque fixed or sticky bar that contains the element; null if it is in none. */
  function barOf(element) {
    for (let at = element; at; at = at.parentElement) if (['fixed', 'sticky'].includes(styleOf(at).position) && isOpaque(at)) return at;
    return null;
  }
  /** Whether both are visible where they overlap: nothing opaque is between them. */
  function areBothSeen(a, b, x, y) {
    const stack = document.elementsFromPoint(x, y);
    const top = stack.findIndex((element) => element === a || element === b);
    if (top < 0) return true;
    const lower = stack[top] === a ? b : a;
    for (const element of stack) {
      if (element === lower || element.contains(lower)) return true;
      if (isOpaque(element) && !lower.contains(element)) return false;
    }
    return true;
  }
  const meet = (a, b) => ({ x: Math.min(a.right, b.right) - Math.max(a.left, b.left), y: Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) });
  const items = [...controls, ...texts].sort((a, b) => a.box.top - b.box.top);
  const told = new Set();
  for (let i = 0; i < items.length; i++) {
    for (let j = i + 1; j < items.length && items[j].box.top < items[i].box.bottom; j++) {
      const [p, q] = [items[i], items[j]];
      if (isRelated(p.element, q.element) || isSameLabel(p.element, q.element)) continue;
      if (barOf(p.element) !== barOf(q.element)) continue; // permanent covering by a bar is reported below
      // Elements in the same scroller overlap at every scroll position; for others only the visible parts count.
      const isTogether = p.way.scroller === q.way.scroller;
      const both = isTogether ? meet(p.way.kept, q.way.kept) : meet(p.way.seen, q.way.seen);
      // Text boxes are higher than their letters.
      if (both.x < 3 || both.y < (p.isControl && q.isControl ? 3 : 5)) continue;
      // Clipping by an ancestor is reported above; parts scrolled out of view are invisible.
      if (p.way.fault || q.way.fault || isMenu(p.element) !== isMenu(q.element)) continue;
      // A badge on the corner of a control that lets clicks through.
      if (p.isControl !== q.isControl && styleOf((p.isControl ? q : p).element).pointerEvents === 'none') continue;
      const key = `${placeOf(p.element)} ${placeOf(q.element)}`;
      if (told.has(key) || isMeant('overlap', p.element, q.element)) continue;
      p.element.scrollIntoView({ block: 'center', inline: 'nearest', behavior: 'instant' });
      const [a, b] = [p, q].map(({ element, isControl, box }) => {
        range.selectNodeContents(element);
        return (isControl ? boxesOf(element) : [...range.getClientRects()]).find((one) => Math.abs(one.width - box.width) < 1) ?? element.getBoundingClientRect();
      });
      const still = meet(a, b);
      if (still.x < 2 || still.y < 2) continue; // a fixed element over a scrolling one
      const x = (Math.max(a.left, b.left) + Math.min(a.right, b.right)) / 2;
      const y = (Math.max(a.top, b.top) + Math.min(a.bottom, b.bottom)) / 2;
      if (!areBothSeen(p.element, q.element, x, y)) continue;
      told.add(key);
      tell('overlap', p.element, `overlaps ${placeOf(q.element)} by ${Math.round(both.x)} × ${Math.round(both.y)} px`, q.element);
    }
  }

  // ---- covered texts

  /** The current box of a line of text; undefined if it cannot be determined. */
  function lineOf({ box, node }) {
    range.selectNodeContents(node);
    return [...range.getClientRects()].find((one) => Math.abs(one.width - box.width) < 1 && Math.abs(one.height - box.height) < 1);
  }
  /** The element that currently covers a text; null if there is none or it cannot be determined. */
  function whatCovers(item) {
    const { element, way } = item;
    const now = lineOf(item);
    if (!now) return null;
    const y = (now.top + now.bottom) / 2;
    const right = now.left + Math.min(now.width, way.kept.right - way.kept.left);
    for (const share of [0, 0.25, 0.5, 0.75, 1]) {
      const x = now.left + 2 + share * (right - now.left - 4);
      if (x < 0 || x >= width || y < 0 || y >= height) continue;
      const stack = document.elementsFromPoint(x, y);
      // An element that is not in the stack is clipped by a scroller or ignores the pointer.
      const above = stack.slice(0, Math.max(0, stack.indexOf(element))).find((one) => isOpaque(one) && !one.contains(element));
      if (above && !isMenu(above)) return above;
    }
    return null;
  }
  for (const item of texts) {
    if (item.way.fault || isMeant('overlap', item.element)) continue;
    const { top, bottom } = item.element.getBoundingClientRect();
    if (top >= 0 && bottom <= height && !whatCovers(item)) continue;
    // A fixed element covers what scrolls below it, which scrolling can reveal.
    item.element.scrollIntoView({ block: 'center', inline: 'nearest', behavior: 'instant' });
    // For a text higher than the window: this line.
    const line = lineOf(item);
    if (line && bottom - top > height / 2) scrollBy({ top: line.top - height / 2, behavior: 'instant' });
    const above = whatCovers(item);
    if (above) tell('overlap', item.element, `its text "${shorten(item.text)}" is covered by ${placeOf(above)}`, above);
  }

  // ---- clickable areas

  const hits = (element, hit) => hit === element || element.contains(hit) || isSameLabel(element, hit);
  for (const { element, way } of controls) {
    const style = styleOf(element);
    if (style.pointerEvents === 'none') continue;
    if (way.fault) continue;
    element.scrollIntoView({ block: 'center', inline: 'nearest', behavior: 'instant' });
    const [box] = boxesOf(element);
    if (!box || isMeant('overlap', element)) continue;
    const inset = Math.min(5 + 0.3 * (parseFloat(style.borderTopLeftRadius) || 0), box.width / 3, box.height / 3);
    const points = [[(box.left + box.right) / 2, (box.top + box.bottom) / 2],
      [box.left + inset, box.top + inset], [box.right - inset, box.top + inset], [box.left + inset, box.bottom - inset], [box.right - inset, box.bottom - inset]];
    for (const [x, y] of points) {
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const hit = document.elementFromPoint(x, y);
      if (!hit || hits(element, hit) || hit.contains(element) || isMenu(hit)) continue;
      tell('overlap', element, `is covered by ${placeOf(hit)}`, hit);
      break;
    }
    if (!isTouch || style.display === 'inline') continue; // a link in a sentence is as high as its line
    const target = labelOf(element)?.getBoundingClientRect() ?? box;
    const size = { x: Math.max(box.width, target.width), y: Math.max(box.height, target.height) };
    const [x, y] = [(box.left + box.right) / 2, (box.top + box.bottom) / 2];
    const reach = finger / 2 - 0.75;
    const reaches = (dx, dy) => { const hit = document.elementFromPoint(x + dx * reach, y + dy * reach); return hit !== null && hits(element, hit); };
    const isWide = size.x >= finger - 0.5 || (reaches(-1, 0) && reaches(1, 0));
    const isHigh = size.y >= finger - 0.5 || (reaches(0, -1) && reaches(0, 1));
    if (!isWide || !isHigh) tell('small', element, `is ${Math.round(size.x)} × ${Math.round(size.y)} px; a finger needs ${finger} × ${finger}`);
  }

  // ---- images

  const pictures = [...all.querySelectorAll('canvas[data-testid^="camera-picture-"]')].map((element) => {
    element.scrollIntoView({ block: 'center', inline: 'nearest', behavior: 'instant' });
    const box = element.getBoundingClientRect();
    const { seen, fault } = follow(element, box, false);
    return { element, box, width: Math.max(0, seen.right - seen.left), height: Math.max(0, seen.bottom - seen.top), fault };
  });
  if (pictures.length) {
    const shorter = (one) => Math.min(one.width, one.height);
    const cameras = new Set(pictures.map(({ element }) => element.dataset.testid)).size;
    const least = (leastImage * Math.min(width, height)) / Math.ceil(Math.sqrt(cameras));
    // Of several images of one camera, the largest counts.
    const best = new Map();
    for (const one of pictures) {
      const { testid } = one.element.dataset;
      if (!best.has(testid) || shorter(one) > shorter(best.get(testid))) best.set(testid, one);
    }
    for (const one of best.values()) {
      if (shorter(one) < least - 1) tell('image', one.element, `shows ${Math.round(one.width)} × ${Math.round(one.height)} px; it needs ${Math.round(least)} px of both`);
      if (one.width * one.height < 0.97 * one.box.width * one.box.height) tell('image', one.element, `of its ${Math.round(one.box.width)} × ${Math.round(one.box.height)} px only ${Math.round(one.width)} × ${Math.round(one.height)} px can be seen at once`);
    }
  }
  return faults;
}

/** All layout faults of a page, as {kind, at, what}. `isTouch`: for touch input. `meant`: additional exceptions. */
export async function layoutFaults(page, { isTouch = false, meant = [] } = {}) {
  return page.evaluate(look, { isTouch, exceptions: [...exceptions, ...meant], finger: FINGER_PX, leastImage: LEAST_IMAGE });
}
