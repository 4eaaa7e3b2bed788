// An operator's orders to a session: let the daemon decide, keep an arm, reconnect, end the session. Each needs a confirmation and adds
// a row to the audit log. Orders with an opposite can be undone.
import { signal } from '@preact/signals';
import { useState } from 'preact/hooks';
import { SessionsService, type SessionInfo } from '../../../gen/sweepstake/v1/sessions_pb';
import { Mode } from '../../../gen/sweepstake/v1/telemetry_pb';
import { Name, visible } from '../../parts/name';
import { confirmed } from '../../parts/dialog';
import { Select } from '../../parts/filter';
import { toast } from '../../parts/toast';
import { account, isOperator } from '../../state/account';
import { asApiError, call } from '../../transport/calls';
import { modeWord } from '../words';

interface Order { mode: Mode; arm: string }

/** The order that waits for the daemon's answer; absent: none. */
const waits = signal<{ sessionId: string; what: string } | undefined>(undefined);

/** Returns the answer to the order; undefined if it failed. */
async function answerTo<Result>(order: Promise<Result>, sessionId: string, what: string): Promise<Result | undefined> {
  const own = waits.value = { sessionId, what };
  try {
    return await order;
  } catch (error) {
    toast(`The order failed: ${asApiError(error).message}`, { isBad: true });
    return undefined;
  } finally {
    if (waits.peek() === own) waits.value = undefined;
  }
}

const orderText = ({ mode, arm }: Order) => (mode === Mode.AI ? 'the daemon decides' : `the game keeps ${visible(arm)}`);

async function give(sessionId: string, order: Order, opposite: Order | undefined): Promise<void> {
  const done = await answerTo(call(SessionsService.method.orderSession, { sessionId, ...order }), sessionId, `Ordering that ${orderText(order)}`);
  if (done) toast(`Done: ${orderText({ mode: done.mode, arm: done.activeArm })}.`, opposite ? { undo: () => void give(sessionId, opposite, undefined) } : {});
}

async function ask({ sessionId, mode, activeArm }: SessionInfo, order: Order): Promise<void> {
  const body = (
    <>
      <p>{order.mode === Mode.AI
        ? 'The daemon chooses the algorithm again, and learns from its cost.'
        : <>The game keeps <Name text={order.arm} /> until the next order. Meanwhile its frames do not become evidence.</>}</p>
      <p class="soft">The audit log records the order. You can undo it.</p>
    </>
  );
  const action = order.mode === Mode.AI ? 'Let the daemon decide' : 'Keep this algorithm';
  if (await confirmed({ title: `${action}?`, body, action })) await give(sessionId, order, { mode, arm: mode === Mode.MANUAL ? activeArm : '' });
}

async function kick({ sessionId, scene }: SessionInfo, mayReturn: boolean): Promise<void> {
  const body = (
    <>
      <p>{mayReturn ? 'The connection is closed. The game connects again, and the session continues.' : 'The session ends. The game does not connect again until it begins a new session.'}</p>
      <p>Scene <Name text={scene} />. Its evidence is kept. {!mayReturn && <b>This cannot be undone.</b>}</p>
    </>
  );
  const action = mayReturn ? 'Reconnect' : 'End session';
  if (!await confirmed({ title: `${action}?`, body, action, isDangerous: !mayReturn })) return;
  const what = mayReturn ? 'connection' : 'session';
  const done = await answerTo(call(SessionsService.method.kickSession, { sessionId, mayReturn }), sessionId, `Ending the ${what}`);
  if (done) toast(`The ${what} was ended.`);
}

export function Orders({ info, arms, isOver }: { info: SessionInfo; arms: readonly string[]; isOver: boolean }) {
  const [chosen, setChosen] = useState('');
  const arm = chosen || info.activeArm;
  const given = waits.value?.sessionId === info.sessionId ? waits.value.what : undefined;
  const isBusy = given !== undefined;
  const refuses = isBusy || !info.takesOrders;
  if (isOver) return null;
  if (!isOperator.value) return <p class="soft orders">Orders need the role operator; yours is {account.value?.role ?? 'unknown'}.</p>;
  return (
    <div class="orders" role="group" aria-label="Orders">
      <button type="button" disabled={refuses || info.mode === Mode.AI} onClick={() => void ask(info, { mode: Mode.AI, arm: '' })}>AI decides</button>
      <Select label="Keep" value={arm} options={[...new Set([info.activeArm, ...arms])].map((name) => [name, visible(name)] as const)} disabled={!info.takesOrders}
        onFocus={() => setChosen(arm)} onChange={setChosen} />
      <button type="button" disabled={refuses} onClick={() => void ask(info, { mode: Mode.MANUAL, arm })}>Pin this algorithm</button>
      <button type="button" disabled={isBusy} onClick={() => void kick(info, true)}>Reconnect</button>
      <button type="button" disabled={isBusy} onClick={() => void kick(info, false)}>End session</button>
      <span class="soft" role="status" title={modeWord(info.mode).meaning}>{isBusy ? `${given} …` : `Now: ${modeWord(info.mode).name}`}</span>
      {!info.takesOrders && <span class="soft">This game takes no orders: its setting allow_operator_orders is off.</span>}
    </div>
  );
}
