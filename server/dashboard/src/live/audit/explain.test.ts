import { create, type Init } from '../transport/messages';
import { describe, expect, it } from 'vitest';
import { rows, setup } from './log.test.sample';
import { AuditKind, type AuditRow, AuditRowSchema } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { costOfSwitch, explained, explainedRow, type Told, toldOfRow } from './explain';

const told: Told = {
  activeArm: 'SAP', candidate: 'KDTree', outcome: DecisionOutcome.HELD_GATE, reason: SwitchReason.UNSPECIFIED, reward: 0.6, rewardVersion: 3,
  arms: ['SAP', 'KDTree'], costsNs: [7600, 7400], verdict: Verdict.AMBIGUOUS, leader: 'KDTree', bestProbability: [0.3, 0.7], expectedLossRatio: 0.03,
  gate: { gain: 0.03, loss: 0.01, horizonS: 200, cooldownS: 40, costS: 8 },
};

describe('why this algorithm', () => {
  it('compares the costs of both algorithms', () => {
    const expected = 'KDTree is expected to take 7.40 µs per frame instead of 7.60 µs, and is the best with a probability of 70 %.';
    expect(explained(told)[0]).toBe(`SAP stays, because the saving would not pay for a switch: ${expected}`);
    const switched = { ...told, outcome: DecisionOutcome.SWITCHED, reason: SwitchReason.POLICY };
    expect(explained(switched)[0]).toBe(`The daemon commanded a switch from SAP to KDTree: ${expected}`);
    const kept = { ...told, candidate: 'SAP', outcome: DecisionOutcome.KEPT, arms: ['Grid', 'SAP', 'KDTree'], costsNs: [9000, 7000, 7400] };
    expect(explained(kept)[0]).toBe('SAP stays: it is expected to take 7.00 µs per frame. KDTree is the cheapest of the others, with 7.40 µs.');
    const cheaper = { ...kept, costsNs: [9000, 7400, 7000] };
    expect(explained(cheaper)[0], 'a policy that draws may keep an algorithm that is not the cheapest').toBe('SAP stays, because the policy chose it again.');
    const { costsNs: _, ...unknown } = told;
    expect(explained(unknown).join(' ')).not.toContain('expected to take');
    expect(explained({ ...unknown, outcome: DecisionOutcome.SWITCHED, reason: SwitchReason.POLICY })[0]).toBe('The daemon commanded a switch from SAP to KDTree. The policy chose the algorithm from the posteriors.');
  });

  it('does not call a saving too small that would pay', () => {
    const tiny = { ...told, gate: { ...told.gate!, gain: 0.003, loss: 0, costS: 0.1 } };
    expect(explained(tiny)[0]).toMatch(/^SAP stays, because the policy does not switch for so small a saving: /);
    expect(explained(tiny)[1]).toContain('pays above a saving of 3.80 ns per frame');
    const free = { ...told, gate: { ...told.gate!, loss: 0, costS: 0 } };
    expect(explained(free)[1]).toMatch(/^Any saving pays for a switch to KDTree, .* is 225 ns per frame[.]$/);
  });

  it('says which saving would pay for the switch', () => {
    // 7600 ns × (1 − e^−((40 × 0.01 + 8) ÷ 200)), and 7600 ns × (1 − e^−0.03)
    expect(explained(told)[1]).toMatch(/^A switch to KDTree pays above a saving of 313 ns per frame: its cost, spread over 200 s, .* is 225 ns per frame[.]$/);
    const { costsNs: _, ...unknown } = told;
    expect(explained(unknown).join(' ')).toMatch(/pays above a saving of 4[.]1 % of the detection time: .* is 3[.]0 % of the detection time[.]/);
    const { gate: __, ...none } = told;
    expect(explained(none).join(' ')).not.toContain('pays above');
  });

  it('says the detection time where rewards tell it, else the reward', () => {
    expect(explained(told).join(' ')).toContain('SAP took 7.58 µs per frame');
    expect(explained({ ...told, rewardVersion: 1 }).join(' ')).toContain('gave SAP a reward of 0.600');
    const { reward: _, ...nothing } = told;
    expect(explained(nothing).join(' ')).toContain('did not become evidence');
  });

  it('states the verdict beside the probability', () => {
    expect(explained(told).at(-1)).toContain('3.0 % on average. The verdict on the scene is “ambiguous”.');
    const later = explained({ ...told, bestProbability: [0.9999], expectedLossRatio: 1e-6 }).at(-1);
    expect(later).toMatch(/over 99\.9 %.* “ambiguous”.* when three decisions in a row agree/);
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
    expect(explainedRow(row, setup)[0]).toMatch(new RegExp(`^The daemon commanded a switch from ${from} to ${to}: ${to} is expected to take `));
  });

  it('name what a switch cost, also if that is nothing', () => {
    const cost = (rebuildTimeNs: bigint, settlingCostNs: bigint) => costOfSwitch(create(AuditRowSchema, { switchCost: { rebuildTimeNs, settlingCostNs } }));
    expect(cost(300_000n, 120_000n)).toBe('The change cost 0.42 ms of frame time.');
    expect(cost(0n, 0n)).toBe('The change cost no frame time that could be measured.');
  });

  it('name who gave an order or did an action', () => {
    const said = (init: Init<AuditRow>) => explainedRow(create(AuditRowSchema, init));
    const order = { kind: AuditKind.ORDER, operatorName: 'ann' };
    expect(said({ ...order, mode: Mode.MANUAL, arm: 'SAP' })).toEqual(['ann ordered the game to keep to SAP.']);
    expect(said({ ...order, mode: Mode.AI })).toEqual(['ann let the daemon decide.']);
    expect(said({ kind: AuditKind.ADMIN, operatorName: 'ann', action: 'kicked session a' })).toEqual(['ann kicked session a.']);
    expect(said({ kind: AuditKind.ADMIN, action: 'token x was made' })).toEqual(['Token x was made.']);
  });
});
