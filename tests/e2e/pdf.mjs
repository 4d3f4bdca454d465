// SPDX-License-Identifier: Apache-2.0
// Extracts the text of a PDF written by Chromium: hexadecimal glyphs, with a table per font that maps them to
// characters.
import { inflateSync } from 'node:zlib';

const pairs = /<([0-9a-fA-F]+)>/g;
const numbers = (text) => [...text.matchAll(pairs)].map(([, hex]) => hex);
const unicode = (hex) => String.fromCodePoint(parseInt(hex, 16));

function glyphNames(table) {
  const names = new Map();
  for (const [, block] of table.matchAll(/beginbfchar([\s\S]*?)endbfchar/g)) {
    const all = numbers(block);
    for (let i = 0; i + 1 < all.length; i += 2) names.set(parseInt(all[i], 16), unicode(all[i + 1]));
  }
  for (const [, block] of table.matchAll(/beginbfrange([\s\S]*?)endbfrange/g)) {
    const all = numbers(block);
    for (let i = 0; i + 2 < all.length; i += 3) {
      const [from, to, first] = all.slice(i, i + 3).map((hex) => parseInt(hex, 16));
      for (let glyph = from; glyph <= to; glyph++) names.set(glyph, String.fromCodePoint(first + glyph - from));
    }
  }
  return names;
}

/** All text, without spaces, which a PDF has only as gaps. */
export function textOfPdf(bytes) {
  const raw = bytes.toString('latin1');
  const objects = new Map();
  for (const { index, 0: begin, 1: number } of raw.matchAll(/(?:^|\n)(\d+) 0 obj\s/g)) {
    const head = raw.slice(index + begin.length, raw.indexOf('endobj', index)).split(/stream\r?\n/, 1)[0];
    // The stated length gives the end, because compressed bytes may contain any keyword.
    const length = /\/Length (\d+)/.exec(head)?.[1], at = /stream\r?\n/g;
    at.lastIndex = index + begin.length + head.length;
    let content = '';
    if (length && at.test(raw)) {
      const stream = bytes.subarray(at.lastIndex, at.lastIndex + Number(length));
      content = (head.includes('/FlateDecode') ? inflateSync(stream) : stream).toString('latin1');
    }
    objects.set(number, { head, content });
  }
  const fonts = new Map();
  for (const [number, { head }] of objects) {
    const table = /\/ToUnicode (\d+) 0 R/.exec(head)?.[1];
    if (table) fonts.set(number, glyphNames(objects.get(table).content));
  }
  // A font has the same name on all pages of a file.
  const named = new Map();
  for (const { head } of objects.values()) {
    for (const [, name, number] of head.matchAll(/\/(F\d+) (\d+) 0 R/g)) if (fonts.has(number)) named.set(name, fonts.get(number));
  }
  let text = '';
  for (const { content } of objects.values()) {
    let font = new Map();
    for (const [, name, hex] of content.matchAll(/\/(F\d+) [\d.]+ Tf|<([0-9A-Fa-f]+)>/g)) {
      if (name) font = named.get(name) ?? new Map();
      else for (const glyph of hex.match(/.{4}/g) ?? []) text += font.get(parseInt(glyph, 16)) ?? '';
    }
  }
  return text.replace(/\s/g, '');
}
