// The state of the connection: whether the page shows the daemon's current data. The daemon sends nothing while nothing changes, so after
// some silence the page requests /livez. Without an answer the page's data is stale.
import { computed, signal } from '@preact/signals';
import { type ApiError, urlOf } from '../transport/calls';
import type { LinkStatus } from '../transport/events';

// 'stale': connected, but nothing was received for 5 s, not even an answer from /livez.
export type ConnectionStatus = LinkStatus | 'stale';

interface Connection {
  status: ConnectionStatus;
  sinceMs: number;  // since 1970, by the browser's clock
  error?: ApiError;  // the reason, if the daemon gave one
}

const STALE_MS = 5000;  // silence after which the data is stale
const ASK_AFTER_MS = 3500;  // silence after which the page requests /livez
const PATIENCE_MS = 2500;  // timeout of the request
const BEAT_MS = 500;  // interval of the check

// From worst to best. The status of the page is the status of its worst stream.
const ORDER: readonly ConnectionStatus[] = ['denied', 'offline', 'connecting', 'stale', 'live'];

const streams = signal<ReadonlyMap<string, Connection>>(new Map());
const staleSinceMs = signal(0);  // 0: not stale

export const connection = computed((): Connection => {
  const all = [...streams.value.values()].map((each): Connection =>
    (each.status === 'live' && staleSinceMs.value ? { status: 'stale', sinceMs: staleSinceMs.value } : each));
  if (all.length === 0) return { status: 'connecting', sinceMs: Date.now() };
  const rank = (each: Connection) => ORDER.indexOf(each.status);
  return all.reduce((worst, each) => (rank(each) < rank(worst) ? each : worst));
});

export function setConnection(stream: string, next: Omit<Connection, 'sinceMs'>): void {
  const before = streams.peek().get(stream);
  if (before?.status === next.status && before.error?.message === next.error?.message) return;
  streams.value = new Map(streams.peek()).set(stream, { ...next, sinceMs: Date.now() });
}

let heardMs = Date.now();
let isAsking = false;

/** Must be called for each event and comment of a stream, and for each answer of /livez: they show that the daemon can be reached. */
export function heard(): void {
  heardMs = Date.now();
  staleSinceMs.value = 0;
}

async function ask(): Promise<void> {
  isAsking = true;
  // Without an answer `heard` is not called, so the time of silence grows. An error may be the answer of a proxy.
  await fetch(urlOf('/livez'), { cache: 'no-store', signal: AbortSignal.timeout(PATIENCE_MS) })
    .then(({ ok }) => { if (ok) heard(); }, () => undefined);
  isAsking = false;
}

function beat(): void {
  if (document.hidden) return;
  const silentMs = Date.now() - heardMs;
  if (silentMs > STALE_MS && staleSinceMs.peek() === 0) staleSinceMs.value = Date.now();
  if (silentMs > ASK_AFTER_MS && !isAsking) void ask();
}

// Starts the check. When a hidden page is shown, the time of silence starts at zero, because its timers did not run.
export function startPulse(): void {
  setInterval(beat, BEAT_MS);
  document.addEventListener('visibilitychange', () => {
    if (!document.hidden) heard();
  });
}
