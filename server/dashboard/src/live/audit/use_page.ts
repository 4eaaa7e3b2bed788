// Data of the view of decisions: the list of logs, a page of rows, or one row.
import { useEffect, useState } from 'preact/hooks';
import type { AuditSegment } from '../../gen/sweepstake/v1/audit_pb';
import { type ApiError, asApiError } from '../transport/calls';
import { auditRows, auditSegments, type PlacedRow, type Selection } from './log';
import { collectPage, type Filter, findRow, type Page } from './page';

/** The value and its time by the browser's clock, or the error; while reading, the number of rows read. */
export interface Reading<Value> { value?: Value; error?: ApiError; atMs?: number; rowCount: number; again: () => void }

/** Reads again whenever `key` changes, and when `again` is called. */
function useReading<Value>(key: string, read: (cancel: AbortSignal, onProgress: (rowCount: number) => void) => Promise<Value>): Reading<Value> {
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
  useReading<Page>(JSON.stringify([selection, filter, page]), (cancel, onProgress) => collectPage(auditRows(selection, cancel), filter, page, onProgress));

/** Returns the row with that id; null if the log does not contain it, or if the id is empty. */
export const useRow = (sessionId: string, id: string) =>
  useReading<PlacedRow | null>(`${sessionId}\n${id}`, async (cancel) =>
    (id ? (await findRow(auditRows({ sessionId }, cancel), id)) ?? null : null));
