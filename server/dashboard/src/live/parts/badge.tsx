// Whether what is shown is what the daemon knows, always in sight.
import { connection, type ConnectionStatus } from '../state/connection';
import { duration, now } from './clock';
import type { Tone } from './chips';

const WORDS: Readonly<Record<ConnectionStatus, { tone: Tone; sign: string; text: string; meaning: string }>> = {
  live: { tone: 'good', sign: '●', text: 'live', meaning: 'What you see is what the daemon knows.' },
  connecting: { tone: 'plain', sign: '◌', text: 'connecting', meaning: 'The page has not heard of the daemon yet.' },
  stale: { tone: 'warn', sign: '◍', text: 'stale', meaning: 'The connection is there, but the daemon has said nothing for 5 s. What you see may be old.' },
  offline: { tone: 'bad', sign: '✕', text: 'offline', meaning: 'The daemon is away. What you see is what it said last; the page comes back by itself.' },
  denied: { tone: 'bad', sign: '⊘', text: 'no access', meaning: 'The daemon does not let you see this.' },
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
