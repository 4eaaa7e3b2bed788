// Short coloured labels, such as a verdict or a state. Each has a word and a symbol, so that it does not depend on colour.
import type { ComponentChildren } from 'preact';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { verdictWord } from '../views/words';

export type Tone = 'good' | 'warn' | 'bad' | 'plain';

const TONES: Readonly<Record<Verdict, Tone>> = {
  [Verdict.STABLE]: 'good', [Verdict.TIE]: 'good', [Verdict.AMBIGUOUS]: 'warn', [Verdict.DEGRADED]: 'bad', [Verdict.UNSPECIFIED]: 'plain',
};

export function Chip({ tone, sign, title, children }: { tone: Tone; sign?: string; title?: string; children: ComponentChildren }) {
  return <span class={`chip ${tone}`} title={title}>{sign && <span aria-hidden="true">{sign} </span>}{children}</span>;
}

export function VerdictChip({ verdict }: { verdict: Verdict }) {
  const { name, mark, meaning } = verdictWord(verdict);
  return <Chip tone={TONES[verdict] ?? 'plain'} sign={mark} title={meaning}>{name}</Chip>;
}
