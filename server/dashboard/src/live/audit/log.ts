// Reads the audit log from the daemon row by row, so that a log of any length fits in memory.
import { AuditKind, type AuditRow, type AuditSegment, AuditService, type AuditSetup } from '../../gen/sweepstake/v1/audit_pb';
import { stream } from '../transport/calls';

export interface Selection { sessionId?: string; project?: string; scene?: string }

/** A row with the setup of its segment; absent if that row was removed. */
export interface PlacedRow { row: AuditRow; setup?: AuditSetup }

/** Yields the selected rows, oldest first; of one session, those after the row `after`. Throws ApiError. */
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

/** Returns the stored segments, the newest first. Throws ApiError. */
export async function auditSegments(selection: Selection, signal?: AbortSignal): Promise<AuditSegment[]> {
  const all: AuditSegment[] = [];
  for await (const { segments } of stream(AuditService.method.listAuditSegments, selection, signal)) all.push(...segments);
  return all.sort((a, b) => Number(b.unixStartMs - a.unixStartMs) || a.sessionId.localeCompare(b.sessionId) || b.segment - a.segment);
}
