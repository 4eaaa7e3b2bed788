// Keeps the page's state up to date: follows the daemon's streams while the page is open, and writes their messages into scenes.ts
// and sessions.ts.
import { batch, effect, signal } from '@preact/signals';
import { PosteriorsService, type DecisionEvent, type ScenePosterior, type WatchPosteriorsResponse } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionsService, type SessionInfo, type WatchSessionsResponse } from '../../gen/sweepstake/v1/sessions_pb';
import { Watch, type Listener } from '../transport/events';
import { heard, setConnection, startPulse } from './connection';
import { account, learnAccount, needsLogin } from './account';
import * as scenes from './scenes';
import * as sessions from './sessions';

/** Whether a snapshot of the scenes was received. */
export const areScenesKnown = signal(false);

const ASK_AGAIN_MS = 3000;  // interval of requests for the account until one succeeds
const HIDDEN_INTERVAL_MS = 1000;  // a hidden page has no animation frames and uses a timer instead

let updates: (() => void)[] = [];

function applyUpdates(): void {
  const all = updates;
  updates = [];
  batch(() => all.forEach((update) => update()));
}

// Calls `update` at the next animation frame, together with earlier updates, so that each view is drawn once for any number of messages.
function withNextFrame(update: () => void): void {
  if (updates.push(update) > 1) return;
  if (document.hidden) setTimeout(applyUpdates, HIDDEN_INTERVAL_MS);
  else requestAnimationFrame(applyUpdates);
}

// Returns a listener of one stream. It calls `took` with each snapshot, and once per animation frame with the changes since then.
function listener<Message>(stream: 'scenes' | 'sessions', took: (messages: readonly Message[], isSnapshot: boolean) => void): Listener<Message> {
  let waiting: Message[] | undefined;  // changes to apply at the next frame
  return {
    heard,
    messages(messages, isSnapshot) {
      if (isSnapshot) {
        waiting = undefined;  // changes from here on are applied after the snapshot
        withNextFrame(() => took(messages, true));
      } else if (waiting) {
        waiting.push(...messages);
      } else {
        const taken = waiting = [...messages];
        withNextFrame(() => {
          if (waiting === taken) waiting = undefined;
          took(taken, false);
        });
      }
    },
    status: (status, error) => {
      setConnection(stream, { status, ...(error && { error }) });
      if (error?.needsLogin) void learnAccount();
    },
  };
}

function tookPosteriors(messages: readonly WatchPosteriorsResponse[], isSnapshot: boolean): void {
  const posteriors = messages.map(({ posterior }) => posterior).filter((each): each is ScenePosterior => each !== undefined);
  const decisions: DecisionEvent[] = messages.flatMap((message) => message.decisions);
  if (isSnapshot) scenes.takeSnapshot(posteriors);
  areScenesKnown.value ||= isSnapshot;
  if (!isSnapshot || decisions.length > 0) scenes.takeChanges(isSnapshot ? [] : posteriors, decisions);
  if (decisions.length > 0) sessions.takeDecisions(decisions);
}

function tookSessions(messages: readonly WatchSessionsResponse[], isSnapshot: boolean): void {
  const infos: SessionInfo[] = messages.flatMap((message) => message.sessions);
  if (isSnapshot) sessions.takeSnapshot(infos);
  else sessions.takeChanges(infos, messages.flatMap(({ ended }) => ended));
}

let watches: Watch<never, never>[] | undefined;

function follow(): void {
  watches = [
    new Watch(PosteriorsService.method.watchPosteriors, {}, listener('scenes', tookPosteriors)),
    new Watch(SessionsService.method.watchSessions, {}, listener('sessions', tookSessions)),
  ] as unknown as Watch<never, never>[];
}

function unfollow(): void {
  watches?.forEach((watch) => watch.close());
  watches = undefined;
}

// A browser opens at most six connections to one host, and each page needs two. A hidden page closes its connections when another
// page is shown.
function shareConnections(): void {
  const pages = new BroadcastChannel('sweepstake');
  pages.onmessage = () => document.hidden && unfollow();
  const onVisibility = () => {
    if (document.hidden) return;
    pages.postMessage('shown');
    if (!watches && !needsLogin.peek()) follow();
    watches?.forEach((watch) => watch.retry());
  };
  document.addEventListener('visibilitychange', onVisibility);
  window.addEventListener('online', onVisibility);
  onVisibility();
}

// Starts the streams when the daemon has granted access, and again after a login.
export function startLive(): void {
  // When the page becomes hidden, applies the waiting updates now: its next animation frame comes only when the page is shown again.
  document.addEventListener('visibilitychange', () => document.hidden && applyUpdates());
  startPulse();
  void learnAccount();
  setInterval(() => account.peek() ?? void learnAccount(), ASK_AGAIN_MS);
  let isStarted = false;
  effect(() => {
    if (!account.value || needsLogin.value) return;
    if (!isStarted) shareConnections();
    isStarted = true;
    watches?.forEach((watch) => watch.retry());
  });
}
