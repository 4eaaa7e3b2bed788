// Shows the state of the connection: whether the page shows the daemon's current data. Always visible.
import { connection, type ConnectionStatus } from '../state/connection';
import { duration, now } from './clock';
import type { Tone } from './chips';

const WORDS: Readonly<Record<ConnectionStatus, { tone: Tone; sign: string; text: string; meaning: string }>> = {
  live: { tone: 'good', sign: '●', text: 'live', meaning: 'The page shows the current data of the daemon.' },
  connecting: { tone: 'plain', sign: '◌', text: 'connecting', meaning: 'The page has not received data from the daemon yet.' },
  stale: { tone: 'warn', sign: '◍', text: 'stale', meaning: 'The page is connected, but has received nothing from the daemon for 5 s. The data may be old.' },
  offline: { tone: 'bad', sign: '✕', text: 'offline', meaning: 'The connection to the daemon is lost. The page shows the last data that it received, and reconnects automatically.' },
  denied: { tone: 'bad', sign: '⊘', text: 'no access', meaning: 'The daemon refuses access to this data.' },
};

export function ConnectionBadge() {
  const { status, sinceMs, error } = connection.value;
  const { tone, sign, text, meaning } = WORDS[status];
  const since = status === 'live' ? '' : ` ${duration(now.value - sinceMs)}`;
  return (
    <span class={`chip badge ${tone}`} title={error ? `${meaning} (${error.message})` : meaning} data-status={status}>
      <span aria-hidden="true">{sign} </span><span role="status">{text}</span><span class="since">{since}</span>
    </span>
  );
}
