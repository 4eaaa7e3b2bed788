// Reads rows of the audit log from the daemon, which filters them and answers in pages.
import { call } from '../transport/calls';
import { type Init, toJson } from '../transport/messages';
import { type AuditRow, AuditRowSchema, AuditService, type AuditSetup, type DecisionFilter, type ListDecisionsRequest } from '../../gen/sweepstake/v1/audit_pb';
import { NS_PER_MS } from '../numbers/log_cost';

/** A row of the audit log, and the setup of its segment; absent if the daemon has removed the segment's first row. */
export interface PlacedRow { row: AuditRow; setup?: AuditSetup }

export type Selection = Init<DecisionFilter>;

/** Some rows of the log, newest first. The tokens are the places before and after them. */
export interface LogPart { rows: readonly PlacedRow[]; olderToken: string; newerToken: string; hasMore: boolean }

export const PAGE_ROWS = 100;

export const msOf = (ns: bigint) => Number(ns) / NS_PER_MS;

export const rowId = ({ session, segment, row }: AuditRow) => `${session}.${segment}.${row}`;

/** The wall-clock time of `timeNs`: the segment's start plus the time on the daemon's steady clock since then. */
export const unixMsOf = (setup: AuditSetup, timeNs: bigint) => Number(setup.unixStartMs) + msOf(timeNs - setup.startNs);

async function readPart(request: Init<ListDecisionsRequest>, cancel?: AbortSignal): Promise<LogPart> {
  const { rows, setups, olderToken, newerToken, hasMore } = await call(AuditService.method.listDecisions, request, cancel);
  const known = new Map(setups.map(({ sessionId, segment, setup }) => [`${sessionId}.${segment}`, setup]));
  return { rows: rows.map((row) => {
    const setup = known.get(`${row.session}.${row.segment}`);
    return setup ? { row, setup } : { row };
  }), olderToken, newerToken, hasMore };
}

/** Reads up to `count` rows: the newest ones, those before `place.olderThan`, or the first ones after `place.newerThan`. A filter that few
 * rows match needs several calls. Throws ApiError. */
export async function readRows(filter: Selection, count: number, cancel?: AbortSignal, place: { olderThan?: string | undefined; newerThan?: string | undefined } = {}): Promise<LogPart> {
  const isNewer = Boolean(place.newerThan);
  let all: LogPart | undefined;
  do {
    const from: typeof place = !all ? place : isNewer ? { newerThan: all.newerToken } : { olderThan: all.olderToken };
    const part = await readPart({ filter, pageSize: Math.min(count - (all?.rows.length ?? 0), PAGE_ROWS), ...from }, cancel);
    const [newer, older] = isNewer ? [part, all ?? part] : [all ?? part, part];
    all = { rows: all ? [...newer.rows, ...older.rows] : part.rows, olderToken: older.olderToken, newerToken: newer.newerToken, hasMore: part.hasMore };
  } while (all.hasMore && all.rows.length < count);
  return all;
}

const firstOf = ({ rows: [placed] }: LogPart) => placed ?? null;

/** Reads a row by its id (rowId); null if there is none. */
export async function readRow(id: string, cancel?: AbortSignal): Promise<PlacedRow | null> {
  const [, sessionId, segment, row] = /^(.+)\.(\d{1,9})\.(\d{1,18})$/.exec(id) ?? [];
  return sessionId ? firstOf(await readPart({ filter: { sessionId }, segment: Number(segment), row: BigInt(row!) }, cancel)) : null;
}

export const readDecision = async (sessionId: string, decisionId: bigint, cancel?: AbortSignal) => firstOf(await readPart({ filter: { sessionId }, decisionId }, cancel));

/** Returns all fields of the row that are set, with the path to each. */
export function entriesOf(row: AuditRow): [path: string, text: string][] {
  const flat = (value: unknown, path: string): [string, string][] => {
    if (typeof value !== 'object' || value === null) return [[path, String(value)]];
    if (Array.isArray(value) && typeof value[0] !== 'object') return [[path, value.join(' ')]];
    return Object.entries(value).flatMap(([name, each]) => flat(each, path ? `${path}.${name}` : name));
  };
  return flat(toJson(AuditRowSchema, row), '');
}
