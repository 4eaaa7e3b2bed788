// The alerts of the daemon: the problems that need a person. An operator can mute them.
import { signal } from '@preact/signals';
import { useRef, useState } from 'preact/hooks';
import { counted } from '../../../format';
import { type Alert, AlertSeverity, AlertsService } from '../../../gen/sweepstake/v1/alerts_pb';
import { duration, now, timeText } from '../../parts/clock';
import { Modal } from '../../parts/dialog';
import { visible } from '../../parts/name';
import { useEntered } from '../../parts/table';
import { toast } from '../../parts/toast';
import { account, isOperator } from '../../state/account';
import { alerts, alertsError, hrefOf, learnAlerts } from '../../state/alerts';
import { sessionHref } from '../../state/route';
import { asApiError, call } from '../../transport/calls';

const HOUR_MS = 3_600_000;
const PERIODS: readonly { label: string; ms: number }[] = [{ label: 'Until it ends', ms: 0 }, { label: '1 hour', ms: HOUR_MS }, { label: '1 day', ms: 24 * HOUR_MS }];
const MAX_COMMENT = 200;  // bytes; the daemon refuses longer comments

const asked = signal<Alert | undefined>(undefined);
/** The number of changes by this user, after which the list shows the latest state at once. */
const changeCount = signal(0);

const nameOf = ({ project, scene }: Alert) => (project ? visible(scene) : 'the daemon');

async function change(done: string, task: Promise<unknown>): Promise<void> {
  try {
    await task;
    await learnAlerts();
    toast(done);
  } catch (error) {
    toast(`This failed: ${asApiError(error).message}`, { isBad: true });
  }
  changeCount.value += 1;
}

function Mute({ alert }: { alert: Alert }) {
  const [comment, setComment] = useState('');
  const close = () => { asked.value = undefined; };
  const mute = (ms: number) => {
    close();
    void change(`Muted: ${nameOf(alert)}.`, call(AlertsService.method.silenceAlert, { alertId: alert.id, durationMs: BigInt(ms), comment: comment.trim() }));
  };
  return (
    <Modal title={`Mute the alert about ${nameOf(alert)}?`} onClose={close}>
      <p>{visible(alert.text)}</p>
      <p class="soft">A muted alert stays in the list. It is not counted in the title, and no webhook announces it. The audit log records this.</p>
      <label class="choice"><span>Comment</span><input value={comment} maxLength={MAX_COMMENT} onInput={(event) => setComment(event.currentTarget.value)} /></label>
      <p class="buttons">
        <button type="button" onClick={close}>Cancel</button>
        {PERIODS.map(({ label, ms }) => <button key={label} type="button" class="primary" onClick={() => mute(ms)}>{label}</button>)}
      </p>
    </Modal>
  );
}

function Item({ alert }: { alert: Alert }) {
  const { id, severity, project, text, sessionIds, silence: muted } = alert;
  const isBad = severity === AlertSeverity.SERIOUS;
  const name = nameOf(alert);
  const until = muted && (muted.unixUntilMs ? timeText(Number(muted.unixUntilMs)) : 'it ends');
  return (
    <li class={muted ? 'soft' : isBad ? 'bad' : 'warn'}>
      <span aria-hidden="true">{isBad ? '▲ ' : '△ '}</span>
      <a href={hrefOf(alert)} title={project && `Project ${visible(project)}`}><bdi>{name}</bdi></a>: {visible(text)}{' '}
      {sessionIds.map((session) => <span key={session}><a href={sessionHref(session)}>{session.slice(0, 8)}</a>{' '}</span>)}
      <span class="soft">for {duration(now.value - Number(alert.unixSinceMs))}{muted && `, muted until ${until} by ${visible(muted.silencedBy)}${muted.comment && `: ${visible(muted.comment)}`}`}</span>{' '}
      {isOperator.value && (muted
        ? <button type="button" class="quiet" aria-label={`Unmute ${name}`} onClick={() => void change(`Not muted any more: ${name}.`, call(AlertsService.method.unsilenceAlert, { alertId: id }))}>Unmute</button>
        : <button type="button" class="quiet" aria-label={`Mute ${name}`} onClick={() => { asked.value = alert; }}>Mute</button>)}
    </li>
  );
}

// The list of alerts. It has a fixed size, and does not change while the pointer or the focus is in it, except by the user.
export function Attention() {
  const { isEntered, handlers } = useEntered();
  const latest = { list: alerts.value, changes: changeCount.value };
  const shown = useRef(latest);
  if (!isEntered || shown.current.changes !== latest.changes) shown.current = latest;
  const { list } = shown.current;
  const rest = list ? list.alertCount - list.alerts.length : 0;
  return (
    <section class="attention" aria-labelledby="attention-heading" {...handlers}>
      <h2 id="attention-heading">Needs attention</h2>
      {alertsError.value && <p class="bad">▲ The alerts cannot be read: {alertsError.value.message}</p>}
      {list && list.alerts.length > 0 && <ul>{list.alerts.map((alert) => <Item key={alert.id} alert={alert} />)}</ul>}
      {rest > 0 && <p class="soft">And {counted(rest, 'alert', 'alerts')} with less loss.</p>}
      {list?.alertCount === 0 && !alertsError.value && <p class="soft">Nothing.</p>}
      {list && list.alertCount > 0 && !isOperator.value && <p class="soft">Muting needs the role operator; yours is {account.value?.role ?? 'unknown'}.</p>}
      {asked.value && <Mute alert={asked.value} />}
    </section>
  );
}
