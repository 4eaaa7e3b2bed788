import { describe, expect, it } from 'vitest';
import { AuditKind } from '../../gen/sweepstake/v1/audit_pb';
import type { Step } from '../audit/steps';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import type { Told } from '../audit/explain';
import { joined, thinned, timelineOf, wordsOf } from './timeline';

const told = (activeArm: string, candidate: string, outcome: DecisionOutcome): Told => ({
  activeArm, candidate, outcome, reason: SwitchReason.UNSPECIFIED, arms: [], rewardVersion: 3, verdict: Verdict.AMBIGUOUS, leader: '', bestProbability: [],
  expectedLossRatio: 0, cooldownMs: 400,
});
const decision = (timeMs: number, activeArm: string, candidate: string, outcome: DecisionOutcome): Step =>
  ({ timeMs, kind: AuditKind.TICK, activeArm, decisionId: timeMs, told: told(activeArm, candidate, outcome) });
const { KEPT, SWITCHED, HELD_COOLDOWN, HELD_GATE } = DecisionOutcome;

const steps = [
  decision(100, 'SAP', 'SAP', KEPT), decision(200, 'SAP', 'KDTree', SWITCHED), decision(300, 'KDTree', 'KDTree', KEPT),
  decision(400, 'KDTree', 'SAP', HELD_COOLDOWN), decision(500, 'KDTree', 'SAP', HELD_COOLDOWN), decision(600, 'KDTree', 'SAP', HELD_GATE),
  decision(650, 'KDTree', 'KDTree', KEPT), decision(680, 'KDTree', 'SAP', HELD_GATE),
  { timeMs: 690, kind: AuditKind.BAIL_OUT, activeArm: 'KDTree', decisionId: 0 },
];

const ARMS = ['SAP', 'KDTree'];

describe('a timeline', () => {
  const { spans, shades, marks } = timelineOf(steps, ARMS, 1000);

  it('shows which arm ran when, up to the end', () =>
    expect(spans).toEqual([{ arm: 'SAP', fromMs: 100, toMs: 300 }, { arm: 'KDTree', fromMs: 300, toMs: 1000 }]));

  it('shades the cooldown after a switch, not after the start', () => expect(shades).toEqual([{ kind: 'cooldown', fromMs: 300, toMs: 700 }]));

  it('has a filled mark for a switch and hollow ones for candidates that were held back', () =>
    expect(marks.map(({ arm, isHollow, sign }) => [arm, isHollow, sign])).toEqual([
      ['KDTree', false, ''], ['SAP', true, ''], ['SAP', true, ''], ['SAP', true, ''], ['KDTree', false, '!']]));

  it('joins consecutive decisions that held the same candidate back for the same reason', () =>
    expect(marks.map(({ fromMs, toMs, count }) => [fromMs, toMs, count])).toEqual([[200, 200, 1], [400, 500, 2], [600, 600, 1], [680, 680, 1], [690, 690, 1]]));

  it('describes each mark in words', () => {
    expect(wordsOf(marks[1]!)).toBe('held: cooldown. SAP looks better, but KDTree stays: after a switch 400 ms have to pass before the next one.');
    for (const mark of marks) expect(wordsOf(mark)).toMatch(/\.$/);
  });

  it('ends the cooldown of the first switch where that of the second begins', () => {
    const more = timelineOf([...steps, decision(695, 'SAP', 'SAP', KEPT)], ARMS, 1000);
    expect(more.shades.map(({ fromMs, toMs }) => [fromMs, toMs])).toEqual([[300, 695], [695, 1095]]);
  });

  it('joins intervals with a gap below the limit, and no others', () =>
    expect(joined([{ fromMs: 0, toMs: 10 }, { fromMs: 11, toMs: 12 }, { fromMs: 20, toMs: 21 }], 5)).toEqual([{ fromMs: 0, toMs: 12 }, { fromMs: 20, toMs: 21 }]));

  it('leaves out marks that overlap an earlier mark of the same look', () => {
    const shown = (gapMs: number) => thinned(marks, gapMs).map(({ fromMs }) => fromMs);
    expect(shown(1)).toEqual([200, 400, 600, 680, 690]);
    expect(shown(100)).toEqual([200, 400, 600, 690]);
    expect(shown(1000)).toEqual([200, 400, 690]);
  });

  it('leaves out the marks of arms that have no row', () =>
    expect(timelineOf(steps, ['KDTree'], 1000).marks.map(({ arm }) => arm)).toEqual(['KDTree', 'KDTree']));

  it('of no steps is empty', () => expect(timelineOf([], ARMS, 5)).toEqual({ spans: [], shades: [], marks: [] }));
});
