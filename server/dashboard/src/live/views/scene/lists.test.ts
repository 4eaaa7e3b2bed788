import { create } from '../../transport/messages';
import { describe, expect, it } from 'vitest';
import { DecisionEventSchema } from '../../../gen/sweepstake/v1/posteriors_pb';
import { SessionInfoSchema, SessionState as Link } from '../../../gen/sweepstake/v1/sessions_pb';
import { middleOf } from '../../numbers/histogram';
import type { SessionState } from '../../state/sessions';
import { buildRows, buildStarts } from './lists';

const session = (build: string, state: Link, bucket: number, unixStartMs: bigint): SessionState => ({
  info: create(SessionInfoSchema, { build, state, unixStartMs, droppedFrameCount: 2n }),
  decisions: [1, 2].map(() => create(DecisionEventSchema, { measurements: { frameTimeNs: { bucketSteps: [bucket], counts: [10] }, nativeBytes: {} } })),
});
const all = [session('b2', Link.CONNECTED, 190, 50n), session('b1', Link.LOST, 180, 40n), session('b1', Link.CONNECTED, 200, 30n), session('', Link.CONNECTED, 1, 1n)];

describe('builds', () => {
  it('have the percentiles over the frames of all their sessions', () => {
    const row = buildRows(all).find(({ build }) => build === 'b1')!;
    expect(row).toMatchObject({ sessionCount: 2, onlineCount: 1, droppedCount: 4, frameCount: 40, nativeBytes: undefined, detectionNs: undefined });
    expect(row.frameNs).toEqual([middleOf(180), middleOf(200), middleOf(200)]);
  });
  it('with a name begin with their first session', () =>
    expect(buildStarts(all.map(({ info }) => info))).toEqual([{ build: 'b1', fromMs: 30 }, { build: 'b2', fromMs: 50 }]));
});
