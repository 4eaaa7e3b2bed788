// What the page computes from one row of the audit log.
import { type JsonValue, toJson } from '@bufbuild/protobuf';
import { type AuditRow, AuditRowSchema, type AuditSetup } from '../../gen/sweepstake/v1/audit_pb';

const NS_PER_MS = 1e6;

export const msOf = (ns: bigint) => Number(ns) / NS_PER_MS;

/** Identifies the row within the log. */
export const rowId = ({ session, segment, row }: AuditRow) => `${session}.${segment}.${row}`;

/** The wall-clock time of `timeNs`: the segment's start plus the time on the daemon's steady clock since then. */
export const unixMsOf = (setup: AuditSetup, timeNs: bigint) => Number(setup.unixStartMs) + msOf(timeNs - setup.startNs);

/** Returns all fields of the row that are set, with the path to each. */
export function entriesOf(row: AuditRow): [path: string, text: string][] {
  const flat = (value: JsonValue, path: string): [string, string][] => {
    if (typeof value !== 'object' || value === null) return [[path, String(value)]];
    if (Array.isArray(value) && typeof value[0] !== 'object') return [[path, value.join(' ')]];
    return Object.entries(value).flatMap(([name, each]) => flat(each, path ? `${path}.${name}` : name));
  };
  return flat(toJson(AuditRowSchema, row), '');
}

/** Wraps a function so that it computes each answer once, because views ask for all rows whenever one is added. */
export function once<Of extends object, Answer>(compute: (of: Of) => Answer): (of: Of) => Answer {
  const known = new WeakMap<Of, { answer: Answer }>();
  return (of) => {
    const before = known.get(of) ?? { answer: compute(of) };
    known.set(of, before);
    return before.answer;
  };
}

/** The costs of the frames of a decision window. */
export interface WindowMeans {
  frameCount: number;
  frameMs: number; // mean
  detectionMs: number; // mean of the frames that did not rebuild
  checkCount: number; // mean per frame
  nativeBytes: number; // peak
}

/** Undefined: the window has no frames. */
export const windowOf = once((row: AuditRow): WindowMeans | undefined => {
  const window = row.runs?.active?.window;
  const frameCount = Number(window?.frameCount ?? 0);
  if (!window || frameCount === 0) return undefined;
  return {
    frameCount,
    frameMs: window.timeNs / frameCount / NS_PER_MS,
    detectionMs: window.ordinaryFrameCount > 0 ? window.ordinaryDetectionNs / Number(window.ordinaryFrameCount) / NS_PER_MS : Number.NaN,
    checkCount: window.checkCount / frameCount,
    nativeBytes: Number(window.peakBytes),
  };
});
