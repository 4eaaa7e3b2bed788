// The state of the connection: whether the page shows the daemon's current data.
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import type { ApiError } from '../transport/calls';
import { isStale } from '../transport/pulse';

// 'stale': connected, but nothing was received for 5 s, not even an answer from /livez. 'denied': the daemon requires a token, or one
// with more rights.
export type ConnectionStatus = 'connecting' | 'live' | 'stale' | 'offline' | 'denied';

export interface Connection {
  status: ConnectionStatus;
  sinceMs: number;  // since 1970, by the browser's clock
  error?: ApiError;  // the reason, if the daemon gave one
}

// Worst first: the page's status is that of its worst stream.
const ORDER: readonly ConnectionStatus[] = ['denied', 'offline', 'connecting', 'stale', 'live'];

const streams = signal<ReadonlyMap<string, Connection>>(new Map());

const staleSince = computed(() => (isStale.value ? Date.now() : 0));

export const connection: ReadonlySignal<Connection> = computed(() => {
  const all = [...streams.value.values()].map((each): Connection =>
    (each.status === 'live' && staleSince.value ? { status: 'stale', sinceMs: staleSince.value } : each));
  if (all.length === 0) return { status: 'connecting', sinceMs: Date.now() };
  const rank = (each: Connection) => ORDER.indexOf(each.status);
  return all.reduce((worst, each) => (rank(each) < rank(worst) ? each : worst));
});

export function setConnection(stream: string, next: Omit<Connection, 'sinceMs'>): void {
  const before = streams.peek().get(stream);
  if (before?.status === next.status && before.error?.message === next.error?.message) return;
  streams.value = new Map(streams.peek()).set(stream, { ...next, sinceMs: Date.now() });
}
