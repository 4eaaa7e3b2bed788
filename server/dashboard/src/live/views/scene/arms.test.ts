import { create } from '../../transport/messages';
import { describe, expect, it } from 'vitest';
import { DecisionEventSchema, DecisionOutcome, ScenePosteriorSchema } from '../../../gen/sweepstake/v1/posteriors_pb';
import { colourOf } from '../../../palette';
import { armRows, latestSwitches, MAX_SWITCHES, ridgeRows } from './arms';

const posterior = create(ScenePosteriorSchema, {
  rewardVersion: 3,
  arms: [
    { arm: 'A', backendVersion: 1, posterior: { alpha: 60, beta: 40 }, isOutdated: true, windowCount: 5n, visitCount: 2n, effectiveWindowCount: 5.5 },
    { arm: 'A', backendVersion: 2, posterior: { alpha: 55, beta: 45 }, visitCount: 7n, bestProbability: 0.25 },
    { arm: 'B', backendVersion: 1, posterior: { alpha: 70, beta: 30, low95: 0.6, high95: 0.8 }, unixLastSeenS: 7n, bestProbability: 0.75, costRatio: { median: 1, low: 1, high: 1 } },
  ],
});
describe('the rows of a scene', () => {
  const rows = armRows(posterior);
  it('are measured live, in the lane only, or never', () => expect(rows.map(({ measured }) => measured)).toEqual(['live', 'lane', 'never']));
  it('name the version of a backend if there are several', () => expect(rows.map(({ label, isOutdated }) => [label, isOutdated])).toEqual([['A v1', true], ['A v2', false], ['B', false]]));
  it('are drawn with the cheapest arm first and old versions last', () => expect(ridgeRows(rows).map(({ label }) => label)).toEqual(['B', 'A v2', 'A v1']));
  it('have the earlier posterior behind them if it differs', () => {
    const before = create(ScenePosteriorSchema, { arms: [{ arm: 'A', backendVersion: 2, posterior: { alpha: 5, beta: 4 } }, { arm: 'B', backendVersion: 1, posterior: { alpha: 70, beta: 30 } }] });
    expect(ridgeRows(rows, before).map(({ before: was }) => was?.alpha)).toEqual([undefined, 5, undefined]);
  });
});

it('At most MAX_SWITCHES latest switches are marked, in the colour of the new arm', () => {
  const decisions = Array.from({ length: 3 * MAX_SWITCHES }, (_, i) => create(DecisionEventSchema, {
    unixMs: BigInt(i), activeArm: 'Grid', candidateArm: 'SAP', outcome: i % 2 ? DecisionOutcome.SWITCHED : DecisionOutcome.HELD_GATE }));
  const switches = latestSwitches(decisions);
  expect(switches).toHaveLength(MAX_SWITCHES);
  expect([switches[0], switches.at(-1)].map((each) => each!.timeMs)).toEqual([MAX_SWITCHES + 1, 3 * MAX_SWITCHES - 1]);
  expect(new Set(switches.map(({ colour }) => colour))).toEqual(new Set([colourOf('SAP')]));
});
