// Reads the audit log from the daemon row by row, so that no log is too long: what is not asked for is not kept.
import { AuditService, type AuditSegment } from '../../gen/sweepstake/v1/audit_pb';
import { stream } from '../transport/calls';
import { type AuditRow, RowReader, type Setup, setupOf } from './rows';

export interface Selection { sessionId?: string; project?: string; scene?: string }

/** A row with the setup of its segment, if the log still has that. */
export interface PlacedRow { row: AuditRow; setup?: Setup }

const segmentOf = (row: AuditRow) => `${row.text('session')}.${row.text('segment')}`;

/** Yields the rows that the daemon selects, oldest first; of a session, those behind `after`. Throws ApiError. */
export async function* auditRows(selection: Selection, signal?: AbortSignal, after?: PlacedRow): AsyncGenerator<PlacedRow> {
  const reader = new RowReader();
  let segment = after ? segmentOf(after.row) : '';
  let setup = after?.setup;
  const place = after && { afterSegment: Number(after.row.text('segment')), afterRow: BigInt(after.row.text('row')) };
  for await (const { header, rows } of stream(AuditService.method.exportDecisions, { ...selection, ...place }, signal)) {
    if (header) reader.header(header);
    for (const record of rows) {
      const row = reader.row(record);
      if (!row) continue;
      const here = segmentOf(row);
      if (here !== segment) setup = undefined;
      segment = here;
      if (row.text('kind') === 'setup') setup = setupOf(row);
      yield setup ? { row, setup } : { row };
    }
  }
}

/** Returns what there is, the newest segment first. Throws ApiError. */
export async function auditSegments(selection: Selection, signal?: AbortSignal): Promise<AuditSegment[]> {
  const all: AuditSegment[] = [];
  for await (const { segments } of stream(AuditService.method.listAuditSegments, selection, signal)) all.push(...segments);
  return all.sort((a, b) => Number(b.unixStartMs - a.unixStartMs) || a.sessionId.localeCompare(b.sessionId) || b.segment - a.segment);
}
