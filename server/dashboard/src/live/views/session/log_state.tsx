// A line that shows how many rows of a session's log were read, and when. Also decides whether a view reads new rows.
import { grouped } from '../../../format';
import { MAX_STEPS, type SessionLog } from '../../audit/use_log';
import { ago, now } from '../../parts/clock';
import { Failure, Loading } from '../../parts/states';
import { pausedMs } from '../../charts/view_state';
import type { SessionState } from '../../state/sessions';

/** Returns the session's latest decision; undefined while the view is paused. */
export const toldIn = (state: SessionState | undefined) => (pausedMs.value === undefined ? state?.decisions.at(-1) : undefined);

export function LogState({ log }: { log: SessionLog }) {
  if (log.error && log.steps.length === 0) return <Failure what="The session’s log" error={log.error} onRetry={log.again} />;
  if (log.isReading && log.steps.length === 0) return <Loading what="the session’s log" />;
  return (
    <p class="soft log-state">
      <span class="row-count">{grouped(log.droppedCount + log.steps.length)} rows</span> of the audit log, read {ago(log.atMs, now.value)}{log.error && <>: <span role="status">{log.error.message}; the page tries again</span></>}.
      {log.droppedCount > 0 && <> The last {grouped(MAX_STEPS)} are shown; <code>sweepstake audit export</code> writes all rows.</>} <button type="button" class="quiet" disabled={log.isReading} onClick={log.again}>Read again</button>
    </p>
  );
}
