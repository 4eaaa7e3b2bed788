// Whether what the page shows is what the daemon knows.
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import type { ApiError } from '../transport/calls';
import { isStale } from '../transport/pulse';

// 'stale': connected, but nothing has come for 5 s, not even a sign of life. 'denied': the daemon asks for a token, or for another one.
export type ConnectionStatus = 'connecting' | 'live' | 'stale' | 'offline' | 'denied';

export interface Connection {
  status: ConnectionStatus;
  sinceMs: number;  // by the browser's clock, since 1970
  error?: ApiError;  // why, where the daemon said so
}

// Worst first: the page is as well connected as its worst stream.
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
