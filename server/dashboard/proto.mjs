// Generates the types of the protocol's messages and services into src/gen.
//
//   node proto.mjs [PROTOC]
import { execFileSync } from 'node:child_process';
import { mkdirSync, readdirSync, rmSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const path = (name) => fileURLToPath(new URL(name, import.meta.url));
const folder = 'sweepstake/v1/';
const sources = readdirSync(path(`../../proto/${folder}`)).filter((name) => name.endsWith('.proto'));

rmSync(path('src/gen'), { recursive: true, force: true });
mkdirSync(path('src/gen'), { recursive: true });
execFileSync(process.argv[2] ?? 'protoc', [
  `--plugin=protoc-gen-es=${path('node_modules/.bin/protoc-gen-es')}`, `--es_out=${path('src/gen')}`, '--es_opt=target=ts',
  `--proto_path=${path('../../proto')}`, ...sources.map((name) => folder + name),
], { stdio: 'inherit' });
