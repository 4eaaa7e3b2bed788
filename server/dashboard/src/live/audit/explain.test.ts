import { create, type MessageInitShape } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { rows, setup } from './sample_log';
import { AuditKind, AuditRowSchema } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { explained, explainedRow, type Told, toldOfRow } from './explain';

const told: Told = {
  activeArm: 'SAP', candidate: 'KDTree', outcome: DecisionOutcome.HELD_GATE, reason: SwitchReason.UNSPECIFIED, reward: 0.6, rewardVersion: 3,
  verdict: Verdict.AMBIGUOUS, leader: 'KDTree', bestProbability: [0.3, 0.7], expectedLossRatio: 0.03,
  gate: { gain: 0.03, loss: 0.01, horizonS: 200, cooldownS: 40, costS: 8 },
};

describe('why this arm', () => {
  it('weighs what is expected against what it costs', () => {
    const text = explained(told).join(' ');
    expect(text).toContain('KDTree looks better, but SAP stays: the change would not pay');
    expect(text).toContain('save 3.0 % of the detection time for 200 s, which counts as 6.0 s.'); // 200 × 0.03
    expect(text).toContain('cost 1.0 % more for 40 s, until the next switch is allowed, which counts as 400 ms. The switch itself counts as 8.0 s. Altogether the switch does not pay.');
    expect(explained({ ...told, gate: { ...told.gate!, costS: 1 } }).join(' ')).toContain('Altogether the switch would pay.');
    expect(explained({ ...told, gate: { ...told.gate!, loss: 0.5 } }).join(' ')).toContain('may turn out to cost 50 % more');
    const sure = explained({ ...told, gate: { ...told.gate!, gain: Math.log(4), loss: 1e-40 } }).join(' ');
    expect(sure).toContain('save 75 % of the detection time');
    expect(sure).toContain('cost hardly any more for 40 s, until the next switch is allowed, which counts as nothing.');
    expect(explained({ ...told, outcome: DecisionOutcome.SWITCHED, gate: { ...told.gate!, costS: 1 } }).join(' ')).toContain('Altogether the switch pays.');
  });

  it('says the detection time where rewards tell it, else the reward', () => {
    expect(explained(told).join(' ')).toContain('SAP took 7.58 µs per frame');
    expect(explained({ ...told, rewardVersion: 1 }).join(' ')).toContain('gave SAP a reward of 0.600');
    const { reward: _, ...nothing } = told;
    expect(explained(nothing).join(' ')).toContain('did not become evidence');
  });

  it('does not contradict itself where the verdict waits for more decisions', () => {
    expect(explained(told).at(-1)).toContain('3.0 % on average. The scene is called ambiguous: ');
    const later = explained({ ...told, bestProbability: [0.9999], expectedLossRatio: 1e-6 }).at(-1);
    expect(later).toMatch(/over 99\.9 %.* The scene is called ambiguous: .* when three decisions in a row agree/);
    expect(explained({ ...told, verdict: Verdict.DEGRADED, bestProbability: [0.9] }).at(-1)).toContain('The scene is called degraded: ');
  });

  it('has a sentence for every outcome', () => {
    for (const outcome of Object.values(DecisionOutcome).filter((value): value is DecisionOutcome => typeof value === 'number')) {
      for (const sentence of explained({ ...told, outcome })) expect(sentence).toMatch(/[.]$/);
    }
  });
});

describe('the rows of a log', () => {
  it('can all be explained', () => {
    for (const row of rows) {
      const sentences = explainedRow(row, setup);
      expect(sentences.length).toBeGreaterThan(0);
      for (const sentence of sentences) expect(sentence).not.toMatch(/undefined|NaN|unknown/);
    }
  });

  it('name both arms of a switch', () => {
    const row = rows.find((each) => each.decision?.outcome === DecisionOutcome.SWITCHED)!;
    const [from, to] = [row.decision!.activeArm, row.decision!.candidate];
    expect(from).not.toBe(to);
    expect(toldOfRow(row, setup)).toMatchObject({ activeArm: from, candidate: to, outcome: DecisionOutcome.SWITCHED, leader: row.decision!.leader });
    expect(explainedRow(row, setup)[0]).toBe(`The daemon commanded a switch from ${from} to ${to}. The policy chose the arm from the posteriors.`);
  });

  it('name who gave an order or did an action', () => {
    const said = (init: MessageInitShape<typeof AuditRowSchema>) => explainedRow(create(AuditRowSchema, init));
    const order = { kind: AuditKind.ORDER, operatorName: 'ann' };
    expect(said({ ...order, mode: Mode.MANUAL, arm: 'SAP' })).toEqual(['ann ordered the game to keep to SAP.']);
    expect(said({ ...order, mode: Mode.AI })).toEqual(['ann let the daemon decide.']);
    expect(said({ kind: AuditKind.ADMIN, operatorName: 'ann', action: 'kicked session a' })).toEqual(['ann kicked session a.']);
    expect(said({ kind: AuditKind.ADMIN, action: 'token x was made' })).toEqual(['Token x was made.']);
  });
});
