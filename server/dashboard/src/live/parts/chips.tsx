// Short coloured labels, such as a verdict or a state. Each has a word and a symbol, so that it does not depend on colour.
import type { ComponentChildren } from 'preact';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { verdictWord } from '../views/words';
import { connection, type ConnectionStatus } from '../state/connection';
import type { SceneVerdict } from '../state/summaries';
import { duration, now } from './clock';

export type Tone = 'good' | 'warn' | 'bad' | 'plain';

const TONES: Readonly<Record<SceneVerdict, Tone>> = {
  changing: 'good', [Verdict.STABLE]: 'good', [Verdict.TIE]: 'good', [Verdict.AMBIGUOUS]: 'warn', [Verdict.DEGRADED]: 'bad', [Verdict.UNSPECIFIED]: 'plain',
};

export const Chip = ({ tone, sign, title, children }: { tone: Tone; sign?: string; title?: string; children: ComponentChildren }) =>
  <span class={`chip ${tone}`} title={title}>{sign && <span aria-hidden="true">{sign} </span>}{children}</span>;

export function VerdictChip({ verdict }: { verdict: SceneVerdict }) {
  const { name, mark, meaning } = verdictWord(verdict);
  return <Chip tone={TONES[verdict] ?? 'plain'} sign={mark} title={meaning}>{name}</Chip>;
}

const WORDS: Readonly<Record<ConnectionStatus, { tone: Tone; sign: string; text: string; meaning: string }>> = {
  live: { tone: 'good', sign: '●', text: 'live', meaning: 'The page shows the current data of the daemon.' },
  connecting: { tone: 'plain', sign: '◌', text: 'connecting', meaning: 'The page has not received data from the daemon yet.' },
  stale: { tone: 'warn', sign: '◍', text: 'stale', meaning: 'The page is connected, but has received nothing from the daemon for 5 s. The data may be old.' },
  offline: { tone: 'bad', sign: '✕', text: 'offline', meaning: 'The connection to the daemon is lost. The page shows the last data that it received, and reconnects automatically.' },
  denied: { tone: 'bad', sign: '⊘', text: 'no access', meaning: 'The daemon refuses access to this data. Ask its administrator for a token that may read it.' },
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
