// Turns the files of a built page into rows of a C++ table (dashboard_assets.cc.in):
//
//   node embed.mjs FOLDER FILE
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join } from 'node:path';
import { gzipSync } from 'node:zlib';

const TYPES = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript; charset=utf-8', '.css': 'text/css; charset=utf-8', '.svg': 'image/svg+xml',
};
const LINE = 100;  // bytes

const [folder, output] = process.argv.slice(2);

function* filesIn(path) {
  for (const entry of readdirSync(join(folder, path), { withFileTypes: true })) {
    if (entry.isDirectory()) yield* filesIn(`${path}/${entry.name}`);
    else yield `${path}/${entry.name}`;
  }
}

// Each byte has three octal digits, so that a C++ compiler does not add the next character to the escape.
const quoted = (bytes) => `"${[...bytes].map((byte) => `\\${byte.toString(8).padStart(3, '0')}`).join('')}"`;

function literalOf(bytes) {
  const lines = [];
  for (let at = 0; at < bytes.length; at += LINE) lines.push(quoted(bytes.subarray(at, at + LINE)));
  return `${lines.join('\n     ')}sv`;
}

function row(path) {
  const content = readFileSync(join(folder, path));
  const type = TYPES[extname(path)];
  if (!type) throw new Error(`${path}: embed.mjs has no content type for this kind of file; add it to TYPES`);
  const etag = createHash('sha256').update(content).digest('hex').slice(0, 16);
  return `    {"${path}"sv, "${type}"sv,\n     ${literalOf(gzipSync(content, { level: 9 }))},\n     "\\"${etag}\\""sv, ${path.startsWith('/assets/')}},\n`;
}

writeFileSync(output, [...filesIn('')].sort().map(row).join(''));
