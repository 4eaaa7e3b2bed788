// For tests: a log that the daemon wrote.
// @ts-expect-error The page has no types of Node, in which its tests run.
import { readFileSync } from 'node:fs';
import { type AuditRow, RowReader, setupOf } from './rows';

const file = new URL('../../../../../tests/engine_client/decider/audit/logs/adaptive.csv', import.meta.url);
const [header = '', ...lines] = String(readFileSync(file)).split('\n').filter(Boolean);
const reader = new RowReader();
reader.header(header);
export const rows = lines.map((line) => reader.row(line)).filter((row): row is AuditRow => row !== undefined);
export const setup = setupOf(rows[0]!);
