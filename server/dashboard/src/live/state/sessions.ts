// The sessions that the daemon has in memory, and some that ended while the page was open.
import { create } from '../transport/messages';
import { computed, signal } from '@preact/signals';
import { DecisionOutcome, type DecisionEvent } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionEndedSchema, SessionState as Link, type SessionEnded, type SessionInfo } from '../../gen/sweepstake/v1/sessions_pb';
import { bucketsOf, percentile } from '../numbers/histogram';
import { NS_PER_MS } from '../numbers/log_cost';
import { once } from './once';
import { addDecisions, groupedBy } from './scenes';

const MAX_SESSION_DECISIONS = 2000;
export const MAX_ENDED_SESSIONS = 50;

export interface SessionState {
  info: SessionInfo;
  ended?: SessionEnded;  // set when the session has ended; without a reason if it ended while the page was disconnected
  decisions: readonly DecisionEvent[];  // oldest first; up to MAX_SESSION_DECISIONS, fewer if there are many sessions
}

/** All sessions by id. Only this file changes the map. */
export const sessions = signal<ReadonlyMap<string, SessionState>>(new Map());

// Id of the session that a view shows; '': none. This session keeps MAX_SESSION_DECISIONS decisions even if there are many sessions.
export const sessionInView = signal('');

export const isConnected = ({ info, ended }: SessionState) => !ended && info.state === Link.CONNECTED;
export const connectedSessions = computed(() => [...sessions.value.values()].filter(isConnected));

// Returns when the daemon last received a message from the session's game, by its clock; 0: unknown. The daemon sends `info` only when
// another field changes. Decisions arrive at once, so the time of the last decision with frames may be later.
export function lastMessageMs({ info, decisions }: SessionState): number {
  const last = decisions.findLast(({ outcome }) => outcome !== DecisionOutcome.NO_FRAMES);
  return Math.max(Number(info.unixLastMessageMs), Number(last?.unixMs ?? 0n));
}

function forgetEnded(all: Map<string, SessionState>): Map<string, SessionState> {
  const ended = [...all].filter(([, session]) => session.ended);
  for (const [id] of ended.slice(0, Math.max(0, ended.length - MAX_ENDED_SESSIONS))) {
    if (id !== sessionInView.peek()) all.delete(id);
  }
  return all;
}

function withInfo(all: Map<string, SessionState>, infos: readonly SessionInfo[]): Map<string, SessionState> {
  for (const info of infos) all.set(info.sessionId, { info, decisions: all.get(info.sessionId)?.decisions ?? [] });
  return all;
}

// Replaces all sessions by those of a snapshot. A known session that is missing has ended while the page was disconnected.
export function takeSnapshot(infos: readonly SessionInfo[]): void {
  const there = new Set(infos.map(({ sessionId }) => sessionId));
  const gone = [...sessions.peek()].filter(([id]) => !there.has(id)).map(([id, session]): [string, SessionState] =>
    [id, { ...session, ended: session.ended ?? create(SessionEndedSchema, { sessionId: id }) }]);
  const known = [...sessions.peek()].filter(([id]) => there.has(id));
  sessions.value = forgetEnded(withInfo(new Map([...gone, ...known]), infos));
}

export function takeChanges(infos: readonly SessionInfo[], ended: readonly SessionEnded[]): void {
  const next = withInfo(new Map(sessions.peek()), infos);
  for (const end of ended) {
    const session = next.get(end.sessionId);
    if (!session) continue;
    next.delete(end.sessionId);  // inserted again below as the last one: ended sessions are ordered by their end
    next.set(end.sessionId, { ...session, ended: end });
  }
  sessions.value = forgetEnded(next);
}

export function takeDecisions(decisions: readonly DecisionEvent[]): void {
  const next = new Map(sessions.peek());
  addDecisions(next, groupedBy(decisions, ({ sessionId }) => sessionId), MAX_SESSION_DECISIONS, sessionInView.peek());
  sessions.value = next;
}

const frameTimeMs = once(({ measurements }: DecisionEvent): number | undefined => {
  const ns = measurements?.frameTimeNs && percentile(bucketsOf(measurements.frameTimeNs), 0.5);
  return ns === undefined ? undefined : ns / NS_PER_MS;
});

const MAX_TIMES = 60;

/** Returns the median frame time before each of the session's latest decisions in milliseconds, oldest first. */
export const frameTimesOf = (session: Pick<SessionState, 'decisions'> | undefined): number[] =>
  (session?.decisions.slice(-MAX_TIMES) ?? []).map(frameTimeMs).filter((ms) => ms !== undefined);
