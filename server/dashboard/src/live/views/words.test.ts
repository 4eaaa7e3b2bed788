import { describe, expect, it } from 'vitest';
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { SessionEnd, SessionState } from '../../gen/sweepstake/v1/sessions_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { endWord, isHeldBack, kindWord, modeWord, outcomeWord, reasonWord, stateWord, verdictWord, type Word } from './words';

const values = (names: Readonly<Record<string, string | number>>) => Object.values(names).filter((value): value is number => typeof value === 'number');
const ENUMS: readonly (readonly [string, number[], (value: number) => Word])[] = [
  ['outcomes', values(DecisionOutcome), outcomeWord], ['reasons', values(SwitchReason), reasonWord], ['verdicts', values(Verdict), verdictWord],
  ['modes', values(Mode), modeWord], ['states', values(SessionState), stateWord], ['ends', values(SessionEnd), endWord], ['kinds of rows', values(AuditKind), kindWord],
];

describe('the words of the protocol', () => {
  it.each(ENUMS)('name and explain all %s, with distinct names', (_, all, wordOf) => {
    expect(all.length).toBeGreaterThan(2);
    for (const value of all) {
      const { name, meaning, mark } = wordOf(value);
      expect(name, String(value)).toMatch(/^[A-Za-z]/);
      expect(meaning).toMatch(/\.$/);
      expect(mark).not.toBe('');
    }
    expect(new Set(all.map((value) => wordOf(value).name)).size).toBe(all.length);
  });

  it.each(ENUMS)('name values of a newer protocol "unknown": %s', (_, __, wordOf) => expect(wordOf(9999).name).toBe('unknown'));

  it('use the names of `sweepstake watch` for verdicts', () =>
    expect(values(Verdict).map((value) => verdictWord(value).name)).toEqual(['unknown', 'stable', 'tie', 'ambiguous', 'degraded']));
});

it('The outcomes of held-back candidates are cooldown, gate and tie', () =>
  expect(values(DecisionOutcome).filter(isHeldBack)).toEqual([DecisionOutcome.HELD_COOLDOWN, DecisionOutcome.HELD_GATE, DecisionOutcome.HELD_TIE]));
