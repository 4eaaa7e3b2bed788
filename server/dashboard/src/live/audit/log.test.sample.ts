// For tests: the audit log of a real game, read from a file of the daemon's answers to ExportDecisions.
// @ts-expect-error The page has no types of Node, in which its tests run.
import { readFileSync } from 'node:fs';
import { fromJsonText } from '../transport/messages';
import { ExportDecisionsResponseSchema } from '../../gen/sweepstake/v1/audit_pb';

const file = new URL('../../../../../tests/engine_client/decider/audit/logs/adaptive.jsonl', import.meta.url);
export const log = String(readFileSync(file));
export const rows = log.split('\n').filter(Boolean).flatMap((line) => fromJsonText(ExportDecisionsResponseSchema, line).rows);
export const setup = rows[0]!.setup!;
