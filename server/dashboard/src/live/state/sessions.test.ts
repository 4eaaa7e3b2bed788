import { create } from '../transport/messages';
import { describe, expect, it } from 'vitest';
import { DecisionEventSchema } from '../../gen/sweepstake/v1/posteriors_pb';
import { frameTimesOf } from './sessions';

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
