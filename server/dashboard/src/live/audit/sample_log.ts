// For tests: the audit log of a real game, read from a file of the daemon's answers to ExportDecisions.
// @ts-expect-error The page has no types of Node, in which its tests run.
import { readFileSync } from 'node:fs';
import { fromJsonString } from '@bufbuild/protobuf';
import { ExportDecisionsResponseSchema } from '../../gen/sweepstake/v1/audit_pb';

const file = new URL('../../../../../tests/engine_client/decider/audit/logs/adaptive.jsonl', import.meta.url);
export const rows = String(readFileSync(file)).split('\n').filter(Boolean).flatMap((line) => fromJsonString(ExportDecisionsResponseSchema, line).rows);
export const setup = rows[0]!.setup!;
