// A session's log while a view shows it.
import { useEffect, useState } from 'preact/hooks';
import { type ApiError, asApiError } from '../transport/calls';
import { auditRows } from './log';
import { type Step, stepOfRow } from './steps';

/** The latest steps of a longer log stay. At the paper's interval that is some three hours. */
export const MAX_STEPS = 5000;
const SHOW_EVERY = 2000;
/** A log that is not too long is read again so often while it is looked at. */
const AGAIN_MS = 60_000;

export interface SessionLog {
  steps: readonly Step[];
  droppedCount: number; // older steps that were left out
  isReading: boolean;
  atMs: number; // when it was read, by the browser's clock
  error?: ApiError;
  again: () => void;
}

type Reading = Omit<SessionLog, 'again'>;
const BEGIN: Reading = { steps: [], droppedCount: 0, isReading: true, atMs: 0 };

async function read(sessionId: string, cancel: AbortSignal, show: (reading: Reading) => void): Promise<void> {
  let steps: Step[] = [];
  let count = 0;
  const reading = (): Reading => ({ steps: steps.slice(-MAX_STEPS), droppedCount: Math.max(0, count - MAX_STEPS), isReading: true, atMs: Date.now() });
  try {
    for await (const placed of auditRows({ sessionId }, cancel)) {
      const step = stepOfRow(placed);
      if (!step) continue;
      steps.push(step);
      if (steps.length >= 2 * MAX_STEPS) steps = steps.slice(-MAX_STEPS);
      if (++count % SHOW_EVERY === 0) show(reading());
    }
    show({ ...reading(), isReading: false });
  } catch (error) {
    if (!cancel.aborted) show({ ...reading(), isReading: false, error: asApiError(error) });
  }
}

/** Reads the log, and anew when it is asked to, or from time to time while it goes on; what was read before stays until then. */
export function useSessionLog(sessionId: string, goesOn: boolean): SessionLog {
  const [reading, setReading] = useState<Reading>(BEGIN);
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const cancel = new AbortController();
    if (turn === 0) setReading(BEGIN);
    void read(sessionId, cancel.signal, (next) => { if (turn === 0 || !next.isReading) setReading(next); });
    return () => cancel.abort();
  }, [sessionId, turn]);
  useEffect(() => {
    if (!goesOn || reading.isReading || reading.droppedCount > 0) return undefined;
    const timer = setInterval(() => { if (!document.hidden) setTurn((before) => before + 1); }, AGAIN_MS);
    return () => clearInterval(timer);
  }, [goesOn, reading]);
  return { ...reading, again: () => setTurn((before) => before + 1) };
}
