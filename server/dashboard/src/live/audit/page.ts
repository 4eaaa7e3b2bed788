// Pages of a log that is longer than memory: the rows go by, and only those of one page stay.
import type { PlacedRow } from './log';

export const PAGE_ROWS = 100;

/** What a row must be to be shown; empty: anything. */
export interface Filter { kind: string; outcome: string; arm: string }

const ARM_COLUMNS = ['active_arm', 'candidate', 'arm'] as const;

export function matches({ row }: PlacedRow, { kind, outcome, arm }: Filter): boolean {
  return (!kind || row.text('kind') === kind) && (!outcome || row.text('outcome') === outcome)
    && (!arm || ARM_COLUMNS.some((column) => row.text(column) === arm));
}

export interface Page {
  rows: readonly PlacedRow[]; // newest first
  matchCount: number;
  rowCount: number; // that went by
}

/**
 * Collects a page of the rows that match: page 0 has the newest ones. `told` is called from time to time with how many rows have gone
 * by.
 */
export async function collectPage(
  rows: AsyncIterable<PlacedRow>, filter: Filter, page: number, told: (rowCount: number) => void = () => undefined,
): Promise<Page> {
  const reach = (page + 1) * PAGE_ROWS; // of the matches, the last so many are on this page or a newer one
  let kept: PlacedRow[] = [];
  let matchCount = 0;
  let rowCount = 0;
  for await (const placed of rows) {
    if (++rowCount % 1000 === 0) told(rowCount);
    if (!matches(placed, filter)) continue;
    ++matchCount;
    kept.push(placed);
    if (kept.length >= 2 * reach) kept = kept.slice(-reach);
  }
  const end = kept.length - page * PAGE_ROWS;
  return { rows: kept.slice(Math.max(0, end - PAGE_ROWS), Math.max(0, end)).reverse(), matchCount, rowCount };
}

/** Returns the row of that id (AuditRow.id) and reads no further. */
export async function findRow(rows: AsyncIterable<PlacedRow>, id: string): Promise<PlacedRow | undefined> {
  for await (const placed of rows) if (placed.row.id === id) return placed;
  return undefined;
}
