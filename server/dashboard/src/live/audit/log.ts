// Reads the audit log from the daemon row by row, so that a log of any length fits in memory.
import { toJson } from '../transport/messages';
import { AuditKind, type AuditRow, AuditRowSchema, AuditService, type AuditSetup } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { NS_PER_MS } from '../numbers/log_cost';
import { stream } from '../transport/calls';

export interface Selection { sessionId?: string; project?: string; scene?: string }

/** A row of the audit log, and the setup that the first row of its segment contains; absent if the daemon has removed the first row. */
export interface PlacedRow { row: AuditRow; setup?: AuditSetup }

export const msOf = (ns: bigint) => Number(ns) / NS_PER_MS;

/** Identifies the row within the log. */
export const rowId = ({ session, segment, row }: AuditRow) => `${session}.${segment}.${row}`;

/** The wall-clock time of `timeNs`: the segment's start plus the time on the daemon's steady clock since then. */
export const unixMsOf = (setup: AuditSetup, timeNs: bigint) => Number(setup.unixStartMs) + msOf(timeNs - setup.startNs);

/** Yields the selected rows, oldest first. With `after`, yields only the rows after that row; the selection is then one session.
 * Throws ApiError. */
export async function* auditRows(selection: Selection, signal?: AbortSignal, after?: PlacedRow): AsyncGenerator<PlacedRow> {
  let last = after?.row;
  let setup = after?.setup;
  const place = after && { afterSegment: after.row.segment, afterRow: after.row.row };
  for await (const { rows } of stream(AuditService.method.exportDecisions, { ...selection, ...place }, signal)) {
    for (const row of rows) {
      if (row.session !== last?.session || row.segment !== last.segment) setup = undefined;
      last = row;
      if (row.kind === AuditKind.SETUP) setup = row.setup;
      yield setup ? { row, setup } : { row };
    }
  }
}

/** Returns all fields of the row that are set, with the path to each. */
export function entriesOf(row: AuditRow): [path: string, text: string][] {
  const flat = (value: unknown, path: string): [string, string][] => {
    if (typeof value !== 'object' || value === null) return [[path, String(value)]];
    if (Array.isArray(value) && typeof value[0] !== 'object') return [[path, value.join(' ')]];
    return Object.entries(value).flatMap(([name, each]) => flat(each, path ? `${path}.${name}` : name));
  };
  return flat(toJson(AuditRowSchema, row), '');
}

export const PAGE_ROWS = 100;

/** Selects rows. Kind and outcome are names of the protocol's enumerations; an empty field selects everything. */
export interface Filter { kind: string; outcome: string; arm: string }

function matches({ row: { kind, arm, decision } }: PlacedRow, filter: Filter): boolean {
  return (!filter.kind || AuditKind[kind] === filter.kind)
    && (!filter.outcome || (decision !== undefined && DecisionOutcome[decision.outcome] === filter.outcome))
    && (!filter.arm || [decision?.activeArm, decision?.candidate, arm].includes(filter.arm));
}

export interface Page {
  rows: readonly PlacedRow[]; // newest first
  matchCount: number;
  rowCount: number; // rows that were read
}

/** Collects a page of the rows that match; page 0 has the newest ones. Keeps only rows of this page and the newer ones in memory. After
 * every 1000 rows, `show` receives the counts so far. */
export async function collectPage(rows: AsyncIterable<PlacedRow>, filter: Filter, page: number, show: (page: Page) => void): Promise<Page> {
  const reach = (page + 1) * PAGE_ROWS; // number of latest matches on this page and the newer ones
  let kept: PlacedRow[] = [];
  let matchCount = 0;
  let rowCount = 0;
  for await (const placed of rows) {
    if (++rowCount % 1000 === 0) show({ rows: [], matchCount, rowCount });
    if (!matches(placed, filter)) continue;
    ++matchCount;
    kept.push(placed);
    if (kept.length >= 2 * reach) kept = kept.slice(-reach);
  }
  const end = kept.length - page * PAGE_ROWS;
  return { rows: kept.slice(Math.max(0, end - PAGE_ROWS), Math.max(0, end)).reverse(), matchCount, rowCount };
}

/** Returns the row with this id (rowId), and reads no rows after it; null if there is none. */
export async function findRow(rows: AsyncIterable<PlacedRow>, id: string): Promise<PlacedRow | null> {
  for await (const placed of rows) if (rowId(placed.row) === id) return placed;
  return null;
}
