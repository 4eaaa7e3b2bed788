// Pages of a log that is longer than memory: only the rows of one page are kept.
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import type { PlacedRow } from './log';
import { rowId } from './rows';

export const PAGE_ROWS = 100;

/** Selects rows. Kind and outcome are names of the protocol's enumerations; an empty field selects everything. */
export interface Filter { kind: string; outcome: string; arm: string }

export function matches({ row: { kind, arm, decision } }: PlacedRow, filter: Filter): boolean {
  return (!filter.kind || AuditKind[kind] === filter.kind)
    && (!filter.outcome || (decision !== undefined && DecisionOutcome[decision.outcome] === filter.outcome))
    && (!filter.arm || [decision?.activeArm, decision?.candidate, arm].includes(filter.arm));
}

export interface Page {
  rows: readonly PlacedRow[]; // newest first
  matchCount: number;
  rowCount: number; // rows that were read
}

/**
 * Collects a page of the rows that match; page 0 has the newest ones. `onProgress` is called after every 1000 rows with the number of
 * rows read.
 */
export async function collectPage(
  rows: AsyncIterable<PlacedRow>, filter: Filter, page: number, onProgress: (rowCount: number) => void = () => undefined,
): Promise<Page> {
  const reach = (page + 1) * PAGE_ROWS; // number of latest matches on this page and the newer ones
  let kept: PlacedRow[] = [];
  let matchCount = 0;
  let rowCount = 0;
  for await (const placed of rows) {
    if (++rowCount % 1000 === 0) onProgress(rowCount);
    if (!matches(placed, filter)) continue;
    ++matchCount;
    kept.push(placed);
    if (kept.length >= 2 * reach) kept = kept.slice(-reach);
  }
  const end = kept.length - page * PAGE_ROWS;
  return { rows: kept.slice(Math.max(0, end - PAGE_ROWS), Math.max(0, end)).reverse(), matchCount, rowCount };
}

/** Returns the row with that id (rowId) and reads no further. */
export async function findRow(rows: AsyncIterable<PlacedRow>, id: string): Promise<PlacedRow | undefined> {
  for await (const placed of rows) if (rowId(placed.row) === id) return placed;
  return undefined;
}
