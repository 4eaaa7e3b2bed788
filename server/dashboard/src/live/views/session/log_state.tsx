// Whether a session's log is read again and again, how much of it is shown, and how old that is.
import { grouped } from '../../../format';
import { MAX_STEPS, type SessionLog } from '../../audit/use_log';
import { ago, now } from '../../parts/clock';
import { Failure, Loading } from '../../parts/states';
import { pausedMs } from '../../charts/view_state';
import { isConnected, type SessionState } from '../../state/sessions';

/** Whether a session's log has new rows that its view wants. */
export const goesOn = (state: SessionState | undefined) => state !== undefined && isConnected(state) && pausedMs.value === undefined;

export function LogState({ log }: { log: SessionLog }) {
  if (log.error) return <Failure what="The session’s log" error={log.error} onRetry={log.again} />;
  if (log.isReading && log.steps.length === 0) return <Loading what="the session’s log" />;
  return (
    <p class="soft">
      {log.droppedCount > 0 && <>The last {grouped(MAX_STEPS)} rows of the log are shown; {grouped(log.droppedCount)} older ones are in <code>sweepstake audit export</code>. </>}
      The log was read {ago(log.atMs, now.value)}. <button type="button" class="quiet" disabled={log.isReading} onClick={log.again}>Read again</button>
    </p>
  );
}
