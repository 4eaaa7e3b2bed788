// Reads parts of the audit log while a view shows them: the newest rows first, then the new rows after each decision.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import type { DecisionEvent } from '../../gen/sweepstake/v1/posteriors_pb';
import { pausedMs, range, usePaced } from '../charts/view_state';
import { type ApiError, asApiError } from '../transport/calls';
import { readRows } from './log';
import { MAX_STEPS, mergedSteps, type Step, stepsOf } from './steps';
import { grouped } from '../../format';
import { ago, now } from '../parts/clock';
import { CsvLink, sessionCsvUrl } from '../parts/download';
import { Failure, Loading } from '../parts/states';
import type { SessionState } from '../state/sessions';

const FIRST_ROWS = 150;
const OLDER_ROWS = 1000;
/** Delay of reading the log after a decision, because a decision arrives before its row is on disk. */
const READ_AFTER_MS = 200;
const AFTER_ERROR_MS = 3000;

export interface LogReading<Rows> {
  rows: Rows | undefined; // undefined until the first reading is complete
  atMs: number; // time of the latest reading without an error, by the browser's clock
  error?: ApiError;
  isBusy: boolean;
  again: () => void; // reads again
}

/** Calls `read` at first, `afterMs` after a change of `news`, and again after an error that may pass. `read` gets the rows so far. REQUIRES: a
 * component always reads the same part of the log. */
export function useLog<Rows>(news: unknown, read: (before: Rows | undefined, cancel: AbortSignal) => Promise<Rows>, afterMs = READ_AFTER_MS): LogReading<Rows> {
  const [reading, setReading] = useState<Omit<LogReading<Rows>, 'again'>>({ rows: undefined, atMs: 0, isBusy: true });
  const [turn, setTurn] = useState(0);
  const readFor = useRef(news); // the latest news when the log was read last

  useEffect(() => {
    const cancel = new AbortController();
    const { rows, atMs } = reading;
    readFor.current = news;
    setReading({ ...reading, isBusy: true });
    read(rows, cancel.signal).then(
      (next) => !cancel.signal.aborted && setReading({ rows: next, atMs: Date.now(), isBusy: false }),
      (error: unknown) => !cancel.signal.aborted && setReading({ rows, atMs, error: asApiError(error), isBusy: false }));
    return () => cancel.abort();
  }, [turn]);

  const again = () => setTurn((before) => before + 1);
  const isWanted = !reading.isBusy && (reading.error?.mayPass || (news !== undefined && news !== readFor.current));
  useEffect(() => {
    if (!isWanted) return undefined;
    const waitMs = reading.error ? AFTER_ERROR_MS : afterMs;
    const begin = () => {
      if (document.hidden) timer = setTimeout(begin, waitMs);
      else again();
    };
    let timer = setTimeout(begin, waitMs);
    return () => clearTimeout(timer);
  }, [isWanted, reading]);
  return { ...reading, again };
}

interface SessionRows {
  steps: readonly Step[];
  rowCount: number; // rows that were read, including rows that are no steps
  newerToken: string;
  olderToken: string | undefined; // undefined: no older rows can be read
  isWhole: boolean; // the steps begin with the session
}

const NO_ROWS = { steps: [], rowCount: 0, isWhole: false };

export interface SessionLog extends Omit<LogReading<SessionRows>, 'rows'>, Pick<SessionRows, 'steps' | 'rowCount' | 'isWhole'> {
  sessionId: string;
  isReading: boolean; // true until the first reading is complete
  readOlder: (() => void) | undefined; // undefined: no older rows can be read
}

/** Returns the newest rows of a session's log, and reads its new rows when the latest decision `told` changes. Older rows are read if the
 * zoomed range begins before the rows. REQUIRES: a component always passes the same session and number of first rows. */
export function useSessionLog(sessionId: string, told: DecisionEvent | undefined, firstRows = FIRST_ROWS): SessionLog {
  const asksForOlder = useRef(false);
  const log = useLog<SessionRows>(told, async (before, cancel) => {
    const isOlder = before?.olderToken !== undefined && asksForOlder.current;
    asksForOlder.current = false;
    if (!before || isOlder) {
      const part = await readRows({ sessionId }, before ? OLDER_ROWS : firstRows, cancel, { olderThan: before?.olderToken });
      const steps = [...stepsOf(part), ...before?.steps ?? []];
      const hasOlder = part.hasMore && steps.length < MAX_STEPS;
      return { steps, rowCount: (before?.rowCount ?? 0) + part.rows.length, newerToken: before?.newerToken ?? part.newerToken, olderToken: hasOlder ? part.olderToken : undefined, isWhole: !part.hasMore };
    }
    const part = await readRows({ sessionId }, MAX_STEPS, cancel, { newerThan: before.newerToken });
    if (part.rows.length === 0) return { ...before, newerToken: part.newerToken };
    const steps = [...before.steps, ...stepsOf(part)];
    const isCut = steps.length >= 2 * MAX_STEPS;
    return { steps: isCut ? steps.slice(-MAX_STEPS) : steps, rowCount: before.rowCount + part.rows.length, newerToken: part.newerToken, olderToken: isCut ? undefined : before.olderToken, isWhole: before.isWhole && !isCut };
  });
  const { rows, isBusy, error, again } = log;
  const { steps, rowCount, isWhole } = rows ?? NO_ROWS;
  const readOlder = () => {
    asksForOlder.current = true;
    again();
  };
  const isBefore = range.value !== undefined && steps.length > 0 && range.value.fromMs < steps[0]!.timeMs;
  const isWanted = isBefore && rows?.olderToken !== undefined && !isBusy && !error;
  useEffect(() => { if (isWanted) readOlder(); }, [isWanted]);
  return { ...log, sessionId, steps, rowCount, isWhole, isReading: !rows && !error, readOlder: rows?.olderToken === undefined ? undefined : readOlder };
}

const PACE_MS = 400; // limits computations over all steps

/** Returns a session's steps from its log and from the live stream, and whether the log has been read. */
export function useSteps({ steps, isReading }: SessionLog, events: readonly DecisionEvent[] | undefined, rewardVersion: number): { steps: readonly Step[]; hasLog: boolean } {
  const all = useMemo(() => ({ steps, events, isReading }), [steps, events, isReading]);
  const paced = usePaced(all, PACE_MS);
  return useMemo(() => ({ steps: mergedSteps(paced.steps, paced.events ?? [], rewardVersion), hasLog: !paced.isReading }), [paced, rewardVersion]);
}

/** Returns the session's latest decision; undefined while the view is paused. */
export const toldIn = (state: SessionState | undefined) => (pausedMs.value === undefined ? state?.decisions.at(-1) : undefined);

export function LogState({ log: { sessionId, steps, rowCount, isWhole, isReading, isBusy, atMs, error, again, readOlder } }: { log: SessionLog }) {
  if (error && steps.length === 0) return <Failure what="The session’s log" error={error} onRetry={again} />;
  if (isReading && steps.length === 0) return <Loading what="the session’s log" />;
  return (
    <p class="soft log-state">
      {isWhole ? 'All' : 'The newest'} <span class="row-count">{grouped(rowCount)}</span> rows of the audit log, read {ago(atMs, now.value)}{error && <>: <span role="status">{error.message}; the page tries again</span></>}.
      {' '}{readOlder && <button type="button" class="quiet" disabled={isBusy} onClick={readOlder}>Read older rows</button>}
      {' '}<button type="button" class="quiet" onClick={again}>Read again</button> <CsvLink href={sessionCsvUrl('decisions', sessionId)} of="All rows of the log" />
    </p>
  );
}
