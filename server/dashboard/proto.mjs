// Generates the types of the protocol's messages and services into src/gen. Each message has a compact schema, with which
// src/live/transport/messages.ts reads and writes it as JSON.
//
//   node proto.mjs [PROTOC]
import { createFileRegistry, fromBinary, ScalarType } from '@bufbuild/protobuf';
import { FileDescriptorSetSchema } from '@bufbuild/protobuf/wkt';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const path = (name) => fileURLToPath(new URL(name, import.meta.url));
const FOLDER = 'sweepstake/v1/';
const BIG = [ScalarType.INT64, ScalarType.UINT64, ScalarType.SINT64, ScalarType.FIXED64, ScalarType.SFIXED64];
const KINDS = new Map([[ScalarType.STRING, 's'], [ScalarType.BOOL, 'b'], [ScalarType.BYTES, 'y'], ...BIG.map((type) => [type, 'l'])]);
const TYPES = { s: 'string', b: 'boolean', y: 'Uint8Array', l: 'bigint', n: 'number' };

function registryOf(protoc) {
  const folder = mkdtempSync(join(tmpdir(), 'sweepstake_proto_'));
  const sources = readdirSync(path(`../../proto/${FOLDER}`)).filter((name) => name.endsWith('.proto'));
  try {
    execFileSync(protoc, [`--descriptor_set_out=${folder}/set`, '--include_imports', `--proto_path=${path('../../proto')}`,
      ...sources.map((name) => FOLDER + name)], { stdio: 'inherit' });
    return createFileRegistry(fromBinary(FileDescriptorSetSchema, readFileSync(`${folder}/set`)));
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

const isList = (field) => field.fieldKind === 'list';
const otherOf = (field) => field.enum ?? field.message;
const kindOf = (field) => (field.enum ? 'e' : field.message ? 'm' : KINDS.get(field.scalar) ?? 'n');
const isOptional = (field) => !isList(field) && (field.message || field.oneof || field.proto.proto3Optional);

const interfaceOf = (message) => `export interface ${message.name} {\n${message.fields.map((field) => {
  const type = otherOf(field)?.name ?? TYPES[kindOf(field)];
  return `  ${field.localName}${isOptional(field) ? '?' : ''}: ${type}${isList(field) ? '[]' : ''};\n`;
}).join('')}}\n`;

// A field is its name, "*" (list) or "?" (optional), and its kind. Messages and enumerations follow in the order of their fields.
function schemaOf(message) {
  const fields = message.fields.map((field) => `${field.localName}${isList(field) ? '*' : isOptional(field) ? '?' : ''}:${kindOf(field)}`).join(' ');
  const others = message.fields.map(otherOf).filter(Boolean).map((other) => (other.kind === 'enum' ? `${other.name}Names` : `${other.name}Schema`));
  return `export const ${message.name}Schema: Schema<${message.name}> = /* @__PURE__ */ schemaOf('${fields}', () => [${others.join(', ')}]);\n`;
}

function enumOf(each) {
  const prefix = (each.sharedPrefix ?? '').toUpperCase();
  return `export enum ${each.name} {\n${each.values.map(({ localName, number }) => `  ${localName} = ${number},\n`).join('')}}\n`
    + `export const ${each.name}Names: Names = { prefix: '${prefix}', values: ${each.name} };\n`;
}

const methodOf = ({ localName, name, methodKind, input, output, parent }) =>
  `  ${localName}: { kind: '${methodKind}', path: '${parent.typeName}/${name}', input: ${input.name}Schema, output: ${output.name}Schema },\n`;
const serviceOf = (service) => `export const ${service.name} = { method: {\n${service.methods.map(methodOf).join('')}} } as const;\n`;

// Returns the imports of messages and enumerations of other files.
function importsOf(file) {
  const used = [...file.messages.flatMap(({ fields }) => fields.map(otherOf)), ...file.services.flatMap(({ methods }) => methods.flatMap(({ input, output }) => [input, output]))];
  const others = new Map();
  for (const each of used) {
    if (!each || each.file === file) continue;
    const names = others.get(each.file.name) ?? new Set();
    others.set(each.file.name, names.add(`type ${each.name}`).add(each.kind === 'enum' ? `${each.name}Names` : `${each.name}Schema`));
  }
  return [...others].map(([name, names]) => `import { ${[...names].join(', ')} } from './${name.slice(FOLDER.length)}_pb';\n`).join('');
}

function check(file) {
  for (const message of file.messages) {
    const odd = message.nestedMessages.length + message.nestedEnums.length > 0 || message.fields.some(({ fieldKind }) => fieldKind === 'map');
    if (odd) throw new Error(`${message.typeName}: nested types and maps are not supported`);
  }
}

const folder = path(`src/gen/${FOLDER}`);
rmSync(path('src/gen'), { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
// The page does not read errors.proto, which needs google.protobuf.Any.
const isUsed = ({ name, dependencies }) => name.startsWith(FOLDER) && dependencies.every((other) => other.name.startsWith(FOLDER));
for (const file of [...registryOf(process.argv[2] ?? 'protoc').files].filter(isUsed)) {
  check(file);
  writeFileSync(`${folder}${file.name.slice(FOLDER.length)}_pb.ts`, `// Generated by proto.mjs from ${file.name}.proto.\n`
    + `import { ${file.enums.length > 0 ? 'type Names, ' : ''}type Schema, schemaOf } from '../../../live/transport/messages';\n${importsOf(file)}`
    + [...file.enums.map(enumOf), ...file.messages.flatMap((message) => [interfaceOf(message), schemaOf(message)]), ...file.services.map(serviceOf)].join(''));
}
