import { create, type Init } from '../transport/messages';
import { describe, expect, it } from 'vitest';
import { type RegimePosterior, RegimePosteriorSchema, SceneActivitySchema, ScenePosteriorSchema } from '../../gen/sweepstake/v1/posteriors_pb';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { bestDiffer, bestOf, costText, isChanging, leadersOf, presentBest, regimeArms, regimeText, savingText, surenessOf } from './regimes';
import { leaderProbabilityOf } from './scenes';
import { summaryOf, verdictOf } from './summaries';

const regimeOf = (bestArm: string, probability: number): Init<RegimePosterior> => {
  const arms = ['SAP', 'DBVT'].map((arm) => ({ costUs: 100, lowUs: 90, highUs: 110, bestProbability: arm === bestArm ? probability : 1 - probability }));
  return { bestArm, arms, frameShare: 0.5 };
};
const sceneOf = (...regimes: Init<RegimePosterior>[]) => create(ScenePosteriorSchema, {
  verdict: Verdict.STABLE, leaderArm: 'DBVT', arms: [{ arm: 'DBVT', bestProbability: 0.75 }],
  activity: {
    activeArm: 'SAP', arms: ['SAP', 'DBVT'], total: regimeOf('DBVT', 1), regimes, isChanging: new Set(regimes.map(({ bestArm }) => bestArm)).size > 1,
  },
});
const CHANGING = sceneOf(regimeOf('DBVT', 0.96875), regimeOf('SAP', 0.875));
const stateOf = (posterior: typeof CHANGING) => ({ key: 'k', posterior, changedMs: 0, decisions: [] });

describe('a scene whose regimes have different best arms', () => {
  it('is changing, whatever the verdict on all evidence is', () => {
    expect(isChanging(CHANGING)).toBe(true);
    expect(verdictOf(stateOf(CHANGING))).toBe('changing');
  });

  it('has the best arm of each regime as its leaders, and the lowest of their probabilities', () => {
    expect(leadersOf(CHANGING)).toEqual(['DBVT', 'SAP']);
    expect(leaderProbabilityOf(CHANGING)).toBe(0.875);
    expect(surenessOf(CHANGING.activity!)).toBe(0.875);
    expect(bestOf(CHANGING.activity!.regimes[0]!, CHANGING.activity!)!.bestProbability).toBe(0.96875);
  });

  it('has the best arm of the present regime', () => {
    expect(presentBest(CHANGING)).toBeUndefined();
    expect(presentBest(sceneOf(regimeOf('DBVT', 0.96875), { ...regimeOf('SAP', 0.875), isPresent: true }))).toEqual({ number: 2, arm: 'SAP', probability: 0.875 });
    expect(presentBest(sceneOf({ isPresent: true, frameShare: 0.1 })), 'nothing is known of the regime yet').toBeUndefined();
  });

  it('is listed after unsettled scenes, and before stable ones', () => {
    const stable = sceneOf();
    const { uncertainty } = summaryOf(stateOf(CHANGING));
    expect(uncertainty).toBeGreaterThan(summaryOf(stateOf(stable)).uncertainty);
    expect(uncertainty).toBeLessThan(summaryOf(stateOf({ ...stable, verdict: Verdict.AMBIGUOUS })).uncertainty);
  });
});

describe('a scene without a session', () => {
  it('is changing if its stored regimes have different best arms', () => {
    const scene = sceneOf(regimeOf('DBVT', 1));
    delete scene.activity;
    scene.regimeArms = ['DBVT', 'SAP'];
    expect(verdictOf(stateOf(scene))).toBe('changing');
    expect(leadersOf(scene)).toEqual(['DBVT', 'SAP']);
    expect(leaderProbabilityOf(scene)).toBe(0);
  });
});

describe('a scene with one best arm', () => {
  it('is judged by all evidence', () => {
    const withoutSession = sceneOf();
    delete withoutSession.activity;
    for (const scene of [sceneOf(), sceneOf(regimeOf('DBVT', 1), regimeOf('DBVT', 0.5)), withoutSession]) {
      expect(isChanging(scene)).toBe(false);
      expect(verdictOf(stateOf(scene))).toBe(Verdict.STABLE);
      expect(leadersOf(scene)).toEqual(['DBVT']);
      expect(leaderProbabilityOf(scene)).toBe(0.75);
    }
  });

  it('is not stable while a session switches often, as the daemon reports', () => {
    const scene = sceneOf();
    scene.activity!.isChanging = true;
    expect(verdictOf(stateOf(scene))).toBe('changing');
    expect(bestDiffer(scene)).toBe(false);
    expect(leadersOf(scene)).toEqual(['DBVT']);
  });

  it('is not changing because nothing is known of one regime yet', () => {
    expect(regimeArms(sceneOf({ frameShare: 0.1 }, regimeOf('DBVT', 1), { frameShare: 0.1 }))).toEqual(['DBVT']);
  });

  it('is not changing while a session is connected unless the daemon reports it', () => {
    const scene = sceneOf(regimeOf('DBVT', 1), regimeOf('SAP', 1));
    scene.activity!.isChanging = false;
    expect(bestDiffer(scene)).toBe(true);
    expect(isChanging(scene)).toBe(false);
  });

  it('has no leader before there is evidence', () => expect(leadersOf(create(ScenePosteriorSchema, {}))).toEqual([]));
});

describe('texts', () => {
  it('describe a regime by what was measured', () => {
    expect(regimeText(create(RegimePosteriorSchema, { objectCount: 2000, staticRatio: 0.25, speedMean: 0.125 }))).toBe('2,000 objects, 25.0 % static, speed 0.13 units/frame');
    expect(regimeText(create(RegimePosteriorSchema, { speedMean: 0 }))).toBe('speed 0 units/frame');
    expect(regimeText(create(RegimePosteriorSchema, {}))).toBe('not described');
  });

  it('give a cost with its interval, and a saving with its sign', () => {
    expect(costText(bestOf(CHANGING.activity!.regimes[0]!, create(SceneActivitySchema, { arms: ['SAP', 'DBVT'] })))).toBe('100 µs (90.0 to 110)');
    expect(costText(undefined)).toBeUndefined();
    expect(savingText(12.5)).toBe('12.5 µs');
    expect(savingText(-12.5)).toBe('−12.5 µs');
    expect(savingText(0)).toBe('0 µs');
    expect(savingText(undefined)).toBeUndefined();
  });
});
