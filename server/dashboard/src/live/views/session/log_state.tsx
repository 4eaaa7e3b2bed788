// Whether a view wants what is new of a session's log, how much of it is shown, and how old that is.
import { grouped } from '../../../format';
import { MAX_STEPS, type SessionLog } from '../../audit/use_log';
import { ago, now } from '../../parts/clock';
import { Failure, Loading } from '../../parts/states';
import { pausedMs } from '../../charts/view_state';
import type { SessionState } from '../../state/sessions';

/** The session's latest decision, unless the view stands still. */
export const toldIn = (state: SessionState | undefined) => (pausedMs.value === undefined ? state?.decisions.at(-1) : undefined);

export function LogState({ log }: { log: SessionLog }) {
  if (log.error && log.steps.length === 0) return <Failure what="The session’s log" error={log.error} onRetry={log.again} />;
  if (log.isReading && log.steps.length === 0) return <Loading what="the session’s log" />;
  return (
    <p class="soft">
      <span class="row-count">{grouped(log.droppedCount + log.steps.length)} rows</span> of its log, read {ago(log.atMs, now.value)}{log.error && <>: <span role="status">{log.error.message}, and is asked again</span></>}.
      {log.droppedCount > 0 && <> The last {grouped(MAX_STEPS)} are shown, all of them are in <code>sweepstake audit export</code>.</>} <button type="button" class="quiet" disabled={log.isReading} onClick={log.again}>Read again</button>
    </p>
  );
}
