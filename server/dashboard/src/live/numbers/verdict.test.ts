import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { ArmPosteriorSchema, ScenePosteriorSchema } from '../../gen/sweepstake/v1/posteriors_pb';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { verdictOf, verdictOfLeader } from './verdict';

const scene = (rewardVersion: number, ...arms: [arm: string, backendVersion: number, alpha: number, beta: number][]) =>
  create(ScenePosteriorSchema, { rewardVersion, arms: arms.map(([arm, backendVersion, alpha, beta]) => create(ArmPosteriorSchema, { arm, backendVersion, posterior: { alpha, beta } })) });

describe('the verdict of a scene', () => {
  it('has the limits of engine_client/decider/policy/diagnosis.h', () => {
    expect(verdictOfLeader(0.8, 0.5)).toBe(Verdict.STABLE);
    expect(verdictOfLeader(0.79, 0.005)).toBe(Verdict.TIE);
    expect(verdictOfLeader(0.79, 0.0051)).toBe(Verdict.AMBIGUOUS);
  });

  it('is stable where an arm is clearly the best', () => {
    const { verdict, leader, arms } = verdictOf(scene(3, ['A', 1, 6e5, 4e5], ['B', 1, 5.8e5, 4.2e5]));
    expect([verdict, leader]).toEqual([Verdict.STABLE, 'A']);
    expect(arms[0]!.costRatio).toEqual({ median: 1, low: 1, high: 1 });
    expect(arms[1]!.costRatio!.median).toBeCloseTo(5e9 ** 0.02, 6);
  });

  it('is unknown where nothing is learnt, or of one arm only', () => {
    expect(verdictOf(scene(3, ['A', 1, 1, 1], ['B', 1, 1, 1]))).toMatchObject({ verdict: Verdict.UNSPECIFIED, leader: '', arms: [{}, {}] });
    expect(verdictOf(scene(3, ['A', 1, 500, 2])).leader).toBe('');
    expect(verdictOf(scene(3)).verdict).toBe(Verdict.UNSPECIFIED);
  });

  it('compares the newest version of each backend only', () => {
    const { leader, arms } = verdictOf(scene(1, ['A', 1, 900, 100], ['A', 2, 400, 600], ['B', 1, 700, 300]));
    expect(leader).toBe('B');
    expect(arms[0]).toEqual({});
    expect(arms[1]!.bestProbability! + arms[2]!.bestProbability!).toBeCloseTo(1, 9);
  });

  it('says nothing of costs where rewards do not tell them', () => expect(verdictOf(scene(1, ['A', 1, 9, 1], ['B', 1, 1, 9])).arms[0]!.costRatio).toBeUndefined());

  it('passes over an arm whose numbers are none', () => {
    const { arms, leader } = verdictOf(scene(3, ['A', 1, Number.NaN, 1], ['B', 1, 60, 40], ['C', 1, 40, 60]));
    expect([arms[0], leader]).toEqual([{}, 'B']);
  });

  it('is computed once per message', () => {
    const message = scene(3, ['A', 1, 60, 40], ['B', 1, 40, 60]);
    expect(verdictOf(message)).toBe(verdictOf(message));
  });
});
