// What the view of the decisions reads: the list of logs, a page of rows, or one row.
import { useEffect, useState } from 'preact/hooks';
import type { AuditSegment } from '../../gen/sweepstake/v1/audit_pb';
import { type ApiError, asApiError } from '../transport/calls';
import { auditRows, auditSegments, type PlacedRow, type Selection } from './log';
import { collectPage, type Filter, findRow, type Page } from './page';

/** What was read, at what time by the browser's clock, or why it was not; while it is read, how many rows went by. */
export interface Reading<Value> { value?: Value; error?: ApiError; atMs?: number; rowCount: number; again: () => void }

/** Reads anew whenever `key` is another one, and when it is asked to. */
function useReading<Value>(key: string, read: (cancel: AbortSignal, told: (rowCount: number) => void) => Promise<Value>): Reading<Value> {
  const [reading, setReading] = useState<Omit<Reading<Value>, 'again'>>({ rowCount: 0 });
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const cancel = new AbortController();
    setReading({ rowCount: 0 });
    read(cancel.signal, (rowCount) => { if (!cancel.signal.aborted) setReading({ rowCount }); }).then(
      (value) => { if (!cancel.signal.aborted) setReading({ value, atMs: Date.now(), rowCount: 0 }); },
      (error: unknown) => { if (!cancel.signal.aborted) setReading({ error: asApiError(error), rowCount: 0 }); });
    return () => cancel.abort();
  }, [key, turn]);
  return { ...reading, again: () => setTurn(turn + 1) };
}

export const useSegments = () => useReading<AuditSegment[]>('', (cancel) => auditSegments({}, cancel));

export const usePage = (selection: Selection, filter: Filter, page: number) =>
  useReading<Page>(JSON.stringify([selection, filter, page]), (cancel, told) => collectPage(auditRows(selection, cancel), filter, page, told));

/** The row of that id; null where the log does not have it, or none is asked for. */
export const useRow = (sessionId: string, id: string) =>
  useReading<PlacedRow | null>(`${sessionId}\n${id}`, async (cancel) =>
    (id ? (await findRow(auditRows({ sessionId }, cancel), id)) ?? null : null));
