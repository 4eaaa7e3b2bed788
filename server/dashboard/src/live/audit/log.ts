// Reads the audit log from the daemon row by row, so that no log is too long: what is not asked for is not kept.
import { AuditService, type AuditSegment } from '../../gen/sweepstake/v1/audit_pb';
import { stream } from '../transport/calls';
import { type AuditRow, RowReader, type Setup, setupOf } from './rows';

export interface Selection { sessionId?: string; project?: string; scene?: string }

/** A row with the setup of its segment, if the log still has that. */
export interface PlacedRow { row: AuditRow; setup?: Setup }

/** Yields the rows that the daemon selects, oldest first. Throws ApiError. */
export async function* auditRows(selection: Selection, signal?: AbortSignal): AsyncGenerator<PlacedRow> {
  const reader = new RowReader();
  let segment = '';
  let setup: Setup | undefined;
  for await (const { header, rows } of stream(AuditService.method.exportDecisions, selection, signal)) {
    if (header) reader.header(header);
    for (const record of rows) {
      const row = reader.row(record);
      if (!row) continue;
      const here = `${row.text('session')}.${row.text('segment')}`;
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
