// SPDX-License-Identifier: Apache-2.0
// Plain words: finds words and phrases that are hard to read, above all for non-native speakers, and names of source
// files that do not exist.
//
//   node tests/words.mjs [PATH ...]    files and folders; default: docs, README.md, webui, daemon, systemd
//
// Markdown: prose outside code. Vue, TypeScript, C++: comments, texts between tags, and string literals that hold prose.
// Exit code 1 if it finds any.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import { extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

/** Patterns (whole words, any case, plain text or regular expression), each with what to write instead. */
const AVOID = [
  ['anew', 'write "again", "new" or "re-" (reopen, restart)'],
  ['afresh', 'write "again" or "new"'],
  ['(?:takes?|took|taking) force', 'write "takes effect"'],
  ['(?:put|puts|putting) (?:\\w+ )?into force', 'write "apply"'],
  ['(?:in|into) force', 'write "in effect", "in use" or "current"'],
  ['whoever|whosoever', 'write "a person who", "anyone who" or a noun'],
  ['whence|thence|wherefore', 'write "from where" or "why"'],
  ['pictures?', 'write "image", or "frame" if it is a frame of a camera'],
  ['pictured', 'write "shown"'],
  ['at the camera itself', 'write "on the camera itself"'],
  ['set at the camera', 'write "set on the camera"'],
  ['as it stands|as the camera stands', 'write "current"'],
  ['look(?:s|ed)? again', 'write "check again" or "reload"'],
  ['mend(?:s|ed|ing)?', 'write "fix" or "repair"'],
  ['today\u2019s light|today\'s light', 'write "the current light"'],
  ['twins?', 'write "copy", or name the thing'],
  ['tried out|try out', 'write "test" or "preview"'],
  ['set out for', 'write "target" or "goal"'],
  ['by itself alone|of itself', 'write "automatically"'],
  ['deserves? a word', 'say it'],
  ['put by under', 'write "saved under"'],
  ['Of (?:one|those|that|it|what|this|him|them)\\b(?! (?:the|these|kind))', 'start with the subject: "If the calibration was set by hand, its field size is unknown."', 'cased'],
  ['(?:is|are) those of', 'name the thing'],
  ['find by itself', 'write "automatically"'],
  ['take those of', 'name the thing'],
  ['password of now', 'write "current password"'],
  ['\\d+ set for now|saved as you turn', 'write "set and not saved", or "saved as you change it"'],
  ['taught (?:it|the table)', 'say what was learnt from what'],
  ['(?:or )?use force', 'write what is done anyway'],
  ['the service answered', 'say what the refusal means, not its code'],
  ['known to (?:\\d+ mm|\\{|\\s\\s)', 'write "accurate to"'],
  ['only by force', 'say what the reader is asked'],
  ['(?:\\d+|are \\w+|out) unless said', 'write "default:"'],
  ['of now', 'write "current"'],
  ['taken for lost', 'write "counts as lost"'],
  ['is a \\w+ again, with', 'say what was done: "duplicated as"'],
  ['end(?:s|ed)? other programs', 'write "close"'],
  ['takes? (?:its|their|the) \\w+ away', 'write "remove"'],
  ['no (?:name|address) of this computer|is no address', 'write "is not"'],
  ['drowns?', 'say what is hidden'],
  ['(?:not )?all run', 'write "all are running"'],
  ['what is not right only', 'write "only problems"'],
  ['still uses empty', 'write "is still empty"'],
];

/** Legitimate uses that match a pattern: quoted names of the API and of files. */
const ALLOWED = ['picture=camera', 'picture=labels', 'picture.jpg', 'x-sslv-picture'];

const rules = AVOID.map(([pattern, advice, cased]) => ({ pattern: new RegExp(`(?<![\\w/_.-])(?:${pattern})(?![\\w(_-]|[.=:]\\w)`, cased ? 'g' : 'gi'), advice }));

const blank = (text) => text.replace(/[^\n]/g, ' ');

/** Markdown without fenced and indented code, code spans, addresses of links and HTML comments; lines stay in place. */
function proseOfMarkdown(text) {
  return text.replace(/^```[^]*?^```/gm, blank).replace(/^ {4}.*$/gm, (line) => (/^ {4,}(?:[-*]|\d+\.) /.test(line) ? line : blank(line)))
    .replace(/`[^`\n]*`/g, blank).replace(/\]\([^)]*\)/g, blank);
}

/** A string literal is prose if it has two words or begins like a title. */
const isProse = (text) => /[A-Za-z]{2,}[,.:;]? [A-Za-z]{2,}/.test(text) || /^[A-Z][a-z]+$/.test(text);
const isCodeLike = (text) => /^[\w-]+(?: [\w:-]*-[\w:-]*)*$/.test(text) && !/^[A-Z]/.test(text);

/** Comments and strings of a source in the C family; with `tags` also texts between tags and in attributes. */
function proseOfSource(text, tags) {
  const out = blank(text).split('');
  const keep = (start, end) => { for (let i = start; i < end; i++) if (text[i] !== '\n') out[i] = text[i]; };
  const keepText = (start, end) => keep(start, end);
  const source = tags ? text.replace(/<style[^]*?<\/style>/g, blank) : text;
  const token = /\/\/[^\n]*|\/\*[^]*?\*\/|<!--[^]*?-->|"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\]|\\.)*`/g;
  const inScript = tags ? source.replace(/<template>[^]*<\/template>/, blank) : source;
  for (const found of inScript.matchAll(token)) {
    const [all] = found;
    const start = found.index;
    if (/^(?:\/|<!)/.test(all)) keepText(start, start + all.length);
    else {
      const inner = all.slice(1, -1).replace(/\$\{[^}]*\}/g, (code) => ' '.repeat(code.length));
      if (isProse(inner) && !isCodeLike(inner)) [...inner].forEach((char, i) => { if (char !== '\n') out[start + 1 + i] = char; });
    }
  }
  const template = tags ? source.match(/<template>[^]*<\/template>/) : null;
  if (template) {
    const at = template.index;
    // Keeps only the strings of expressions, and only attributes that are shown or read out.
    for (const found of template[0].matchAll(/(?:title|aria-label|placeholder|alt|label|hint|why)="([^"]*)"|>([^<>]+)</g)) {
      const value = found[1] ?? found[2];
      const start = at + found.index + found[0].indexOf(value);
      const bound = found[1] !== undefined && template[0][found.index - 1] === ':';
      const visible = bound ? blank(value).split('') : [...value.replace(/\{\{[^]*?\}\}/g, blank)];
      const strings = bound ? [[value, 0]] : [...value.matchAll(/\{\{([^]*?)\}\}/g)].map((one) => [one[1], one.index + 2]);
      for (const [code, offset] of strings) {
        for (const one of code.matchAll(/'((?:[^'\\\n]|\\.)*)'|`((?:[^`\\]|\\.)*)`/g)) {
          const inner = (one[1] ?? one[2]).replace(/\$\{[^}]*\}/g, (hole) => ' '.repeat(hole.length));
          if (isProse(inner) && !isCodeLike(inner)) [...inner].forEach((char, i) => { visible[offset + one.index + 1 + i] = char; });
        }
      }
      visible.forEach((char, i) => { if (char !== '\n') out[start + i] = char; });
    }
    for (const found of template[0].matchAll(/<!--[^]*?-->/g)) keep(at + found.index, at + found.index + found[0].length);
  }
  return out.join('').replace(/`[^`\n]*`/g, blank);
}

const PROSE = {
  '.md': proseOfMarkdown,
  '.vue': (text) => proseOfSource(text, true),
  ...Object.fromEntries(['.ts', '.mjs', '.h', '.cpp'].map((type) => [type, (text) => proseOfSource(text, false)])),
};
const SKIP = ['node_modules', 'dist', 'build', 'images'];
/** Generated types, and tests, which quote the service's texts. */
const NOT_OURS = /schema\.d\.ts$|\.test\.ts$/;

function* files(path) {
  if (!statSync(path).isDirectory()) { yield path; return; }
  for (const entry of readdirSync(path, { withFileTypes: true }).sort((a, b) => (a.name < b.name ? -1 : 1))) {
    if (entry.isDirectory() ? !SKIP.includes(entry.name) && !entry.name.startsWith('.') : !NOT_OURS.test(entry.name) && extname(entry.name) in PROSE) yield* files(join(path, entry.name));
  }
}

/** Names of source files, as docs and comments cite them: hello.cpp, kit/stages.h, panel.test.mjs. */
const FILE_NAME = /(?<![\w./<*-])(?:[\w-]+\/)*([\w-]+(?:\.test)?\.(?:h|cpp|mjs))\b(?!\.)/g;
const OF_OTHERS = ['fcntl.h', 'foreach_target.h', 'gl2ext.h', 'gl31.h'];
const ownFiles = new Set(OF_OTHERS);
(function collect(folder) {
  for (const entry of readdirSync(folder, { withFileTypes: true })) {
    if (entry.isDirectory()) { if (!SKIP.includes(entry.name) && !entry.name.startsWith('.')) collect(join(folder, entry.name)); } else ownFiles.add(entry.name);
  }
})(fileURLToPath(new URL('..', import.meta.url)));

let count = 0;
for (const path of process.argv.length > 2 ? process.argv.slice(2) : ['docs', 'README.md', 'webui', 'daemon', 'systemd']) {
  for (const file of files(path)) {
    const text = readFileSync(file, 'utf8');
    const prose = PROSE[extname(file)]?.(text);
    const cited = extname(file) === '.md' ? text : prose?.replace(/^\s*#include.*/gm, '');
    cited?.split('\n').forEach((line, i) => {
      for (const [all, name] of line.matchAll(FILE_NAME)) {
        if (ownFiles.has(name) || /^linux\/|NAME/.test(all)) continue;
        console.log(`${file}:${i + 1}: "${all}": there is no such file`);
        count++;
      }
    });
    prose?.split('\n').forEach((whole, i) => {
      const line = ALLOWED.reduce((left, one) => left.replaceAll(one, ' '.repeat(one.length)), whole);
      for (const { pattern, advice } of rules) {
        for (const found of line.matchAll(pattern)) {
          console.log(`${file}:${i + 1}: "${found[0]}": ${advice}`);
          count++;
        }
      }
    });
  }
}
process.exitCode = count ? 1 : 0;
