// Reads a session's audit log while a view shows it: the whole log once, then the new rows after each decision of the session.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import type { DecisionEvent } from '../../gen/sweepstake/v1/posteriors_pb';
import { pausedMs, usePaced } from '../charts/view_state';
import { type ApiError, asApiError } from '../transport/calls';
import { auditRows, type PlacedRow } from './log';
import { mergedSteps, type Step, stepOfRow } from './steps';
import { grouped } from '../../format';
import { ago, now } from '../parts/clock';
import { Failure, Loading } from '../parts/states';
import type { SessionState } from '../state/sessions';

/** The number of latest steps that are kept, about three hours at the paper's decision interval. */
export const MAX_STEPS = 5000;
const SHOW_EVERY = 2000;
/** Delay of reading the log after a decision, because a decision arrives before its row is on disk. */
const READ_AFTER_MS = 200;
const AFTER_ERROR_MS = 3000;

interface Reading {
  steps: readonly Step[];
  count: number; // steps that were read, including dropped ones
  last?: PlacedRow;
  isReading: boolean; // true until the first reading is complete
  atMs: number; // time of the latest reading without an error, by the browser's clock
  error?: ApiError;
}

export interface SessionLog extends Pick<Reading, 'steps' | 'isReading' | 'atMs' | 'error'> {
  droppedCount: number; // older steps that were dropped
  again: () => void;
}

/** Reads the rows after `before.last`. Passes all steps so far, old and new, to `show`. */
async function readOn(sessionId: string, before: Reading, cancel: AbortSignal, show: (reading: Reading) => void): Promise<void> {
  const steps = [...before.steps];
  let { count, last } = before;
  const reading = (more: Pick<Reading, 'isReading' | 'error'>): Reading =>
    ({ steps: steps.slice(-MAX_STEPS), count, ...(last && { last }), atMs: more.error ? before.atMs : Date.now(), ...more });
  try {
    for await (const placed of auditRows({ sessionId }, cancel, last)) {
      last = placed;
      const step = stepOfRow(placed);
      if (!step) continue;
      steps.push(step);
      if (steps.length >= 2 * MAX_STEPS) steps.splice(0, MAX_STEPS);
      if (++count % SHOW_EVERY === 0) show(reading({ isReading: before.isReading }));
    }
    show(reading({ isReading: false }));
  } catch (error) {
    if (!cancel.aborted) show(reading({ isReading: false, error: asApiError(error) }));
  }
}

/** Returns the session's log, and reads its new rows when `told` changes. `told` is the session's latest decision, or undefined if the
 * view does not show new ones. REQUIRES: a component always passes the same session. */
export function useSessionLog(sessionId: string, told: DecisionEvent | undefined): SessionLog {
  const [reading, setReading] = useState<Reading>({ steps: [], count: 0, isReading: true, atMs: 0 });
  const [turn, setTurn] = useState(0);
  const latest = useRef(reading);
  latest.current = reading;
  const readFor = useRef(told); // the latest decision when the log was read last
  const isBusy = useRef(false);

  useEffect(() => {
    const cancel = new AbortController();
    readFor.current = told;
    isBusy.current = true;
    void readOn(sessionId, latest.current, cancel.signal, setReading).finally(() => { if (!cancel.signal.aborted) isBusy.current = false; });
    return () => cancel.abort();
  }, [turn]);

  const isWanted = reading.error?.mayPass || (told !== undefined && told !== readFor.current);
  useEffect(() => {
    if (!isWanted) return undefined;
    const waitMs = reading.error ? AFTER_ERROR_MS : READ_AFTER_MS;
    const begin = () => {
      if (document.hidden || isBusy.current) timer = setTimeout(begin, waitMs);
      else setTurn((before) => before + 1);
    };
    let timer = setTimeout(begin, waitMs);
    return () => clearTimeout(timer);
  }, [isWanted, reading]);

  const { steps, count, isReading, atMs, error } = reading;
  return { steps, isReading, atMs, ...(error && { error }), droppedCount: count - steps.length, again: () => setTurn((before) => before + 1) };
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

export function LogState({ log }: { log: SessionLog }) {
  if (log.error && log.steps.length === 0) return <Failure what="The session’s log" error={log.error} onRetry={log.again} />;
  if (log.isReading && log.steps.length === 0) return <Loading what="the session’s log" />;
  return (
    <p class="soft log-state">
      <span class="row-count">{grouped(log.droppedCount + log.steps.length)} rows</span> of the audit log, read {ago(log.atMs, now.value)}{log.error && <>: <span role="status">{log.error.message}; the page tries again</span></>}.
      {log.droppedCount > 0 && <> The page shows the last {grouped(MAX_STEPS)}; <code>sweepstake audit export</code> writes all rows.</>} <button type="button" class="quiet" disabled={log.isReading} onClick={log.again}>Read again</button>
    </p>
  );
}
