// What an operator may do with a session: let the daemon decide, keep an arm, end the session. Each is asked about first, has a row in the
// audit log, and can be taken back where an opposite order does.
import { useState } from 'preact/hooks';
import { SessionsService, type SessionInfo } from '../../../gen/sweepstake/v1/sessions_pb';
import { Mode } from '../../../gen/sweepstake/v1/telemetry_pb';
import { Name } from '../../parts/name';
import { confirmed } from '../../parts/dialog';
import { toast } from '../../parts/toast';
import { visible } from '../../parts/visible';
import { account, isOperator } from '../../state/account';
import { asApiError, call } from '../../transport/calls';
import { modeWord } from '../words';

interface Order { mode: Mode; arm: string }

const orderText = ({ mode, arm }: Order) => (mode === Mode.AI ? 'The daemon decides' : `The game keeps to ${visible(arm)}`);

async function give(sessionId: string, order: Order, opposite: Order | undefined): Promise<void> {
  try {
    const { mode, activeArm } = await call(SessionsService.method.orderSession, { sessionId, ...order });
    toast(`Obeyed: ${orderText({ mode, arm: activeArm })}.`, opposite ? { undo: () => void give(sessionId, opposite, undefined) } : {});
  } catch (error) {
    toast(`Not obeyed: ${asApiError(error).message}`, { isBad: true });
  }
}

async function ask({ sessionId, mode, activeArm }: SessionInfo, order: Order): Promise<void> {
  const body = (
    <>
      <p>{order.mode === Mode.AI
        ? 'The daemon chooses the arm again, and learns from what it costs.'
        : <>The game keeps to <Name text={order.arm} /> until it is told otherwise; nothing becomes evidence meanwhile.</>}</p>
      <p class="soft">The order is in the audit log. You can undo it.</p>
    </>
  );
  const action = order.mode === Mode.AI ? 'Let the daemon decide' : 'Keep this arm';
  if (await confirmed({ title: `${action}?`, body, action })) await give(sessionId, order, { mode, arm: mode === Mode.MANUAL ? activeArm : '' });
}

async function kick({ sessionId, scene }: SessionInfo, mayReturn: boolean): Promise<void> {
  const body = (
    <>
      <p>{mayReturn ? 'The connection ends; the game connects again, and the session goes on.' : 'The session ends, and the game decides by itself until it begins a new one.'}</p>
      <p>Scene <Name text={scene} />. What it has measured stays. {!mayReturn && <b>This cannot be undone.</b>}</p>
    </>
  );
  const action = mayReturn ? 'Reconnect' : 'End session';
  if (!await confirmed({ title: `${action}?`, body, action, isDangerous: !mayReturn })) return;
  try {
    await call(SessionsService.method.kickSession, { sessionId, mayReturn });
    toast(mayReturn ? 'The connection was ended.' : 'The session was ended.');
  } catch (error) {
    toast(`Not done: ${asApiError(error).message}`, { isBad: true });
  }
}

export function Orders({ info, arms, isOver }: { info: SessionInfo; arms: readonly string[]; isOver: boolean }) {
  const [chosen, setChosen] = useState('');
  const arm = chosen || info.activeArm;
  if (isOver) return null;
  if (!isOperator.value) return <p class="soft orders">Orders need the role operator; yours is {account.value?.role ?? 'not known'}.</p>;
  return (
    <div class="orders" role="group" aria-label="Orders">
      <button type="button" disabled={info.mode === Mode.AI} onClick={() => void ask(info, { mode: Mode.AI, arm: '' })}>AI decides</button>
      <label class="choice"><span>Keep</span>
        <select value={arm} onFocus={() => setChosen(arm)} onChange={(event) => setChosen(event.currentTarget.value)}>
          {[...new Set([info.activeArm, ...arms])].map((name) => <option key={name} value={name}>{visible(name)}</option>)}
        </select>
      </label>
      <button type="button" onClick={() => void ask(info, { mode: Mode.MANUAL, arm })}>Pin this arm</button>
      <button type="button" onClick={() => void kick(info, true)}>Reconnect</button>
      <button type="button" onClick={() => void kick(info, false)}>End session</button>
      <span class="soft" title={modeWord(info.mode).meaning}>Now: {modeWord(info.mode).name}</span>
    </div>
  );
}
