import { create } from '../transport/messages';
import { describe, expect, it } from 'vitest';
import { DecisionEventSchema, SceneActivitySchema } from '../../gen/sweepstake/v1/posteriors_pb';
import { frameTimesOf, savingsOf } from './savings';

const scene = (total: Readonly<Record<string, number>> | undefined) => ({ activity: create(SceneActivitySchema, total ? { total } : {}) });

describe('savings', () => {
  it('are means over the scenes that have measured them', () => {
    const scenes = [scene({ ranUs: 100, savedAgainstSingleUs: 30, savedAgainstReferenceUs: 10, savedAgainstInitialUs: 60 }),
      scene({ ranUs: 300, savedAgainstSingleUs: -10, savedAgainstReferenceUs: 20, savedAgainstInitialUs: 0 }), scene({ ranUs: 5 }), scene(undefined), {}];
    expect(savingsOf(scenes)).toEqual({ sceneCount: 2, ranUs: 200, againstInitialUs: 30, againstSingleUs: 10, againstReferenceUs: 15 });
  });

  it('have no mean against KDTree or the initial algorithm if a scene does not know it', () => {
    const scenes = [scene({ ranUs: 100, savedAgainstSingleUs: 30, savedAgainstReferenceUs: 10 }), scene({ ranUs: 100, savedAgainstSingleUs: 30, savedAgainstInitialUs: 60 })];
    expect(savingsOf(scenes)).toEqual({ sceneCount: 2, ranUs: 100, againstSingleUs: 30 });
    expect(savingsOf([scene({ ranUs: 100, savedAgainstSingleUs: 30 })])).toEqual({ sceneCount: 1, ranUs: 100, againstSingleUs: 30 });
    expect(savingsOf([scene({ ranUs: 100 }), {}])).toBeUndefined();
  });
});

describe('frame times', () => {
  it('are the medians of the latest decisions that have them', () => {
    const event = (bucket: number) => create(DecisionEventSchema, { measurements: { frameTimeNs: { bucketSteps: [bucket, 8], counts: [3, 1] } } });
    const decisions = [event(8 * 23), create(DecisionEventSchema, {}), event(8 * 24)];
    const [before, now] = frameTimesOf({ decisions });
    expect(before).toBeCloseTo(2 ** (23 - 1 / 16) / 1e6, 6);
    expect(now! / before!).toBeCloseTo(2, 6);
    expect(frameTimesOf({ decisions: Array.from({ length: 70 }, () => event(8)) })).toHaveLength(60);
    expect(frameTimesOf(undefined)).toEqual([]);
  });
});
