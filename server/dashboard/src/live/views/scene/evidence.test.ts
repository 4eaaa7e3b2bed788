import { create } from '@bufbuild/protobuf';
import { expect, it } from 'vitest';
import { SceneComparisonSchema } from '../../../gen/sweepstake/v1/priors_pb';
import { measuredRows, priorRows } from './evidence';

const beta = (alpha: number) => ({ alpha, beta: 1 });
const SCENE = create(SceneComparisonSchema, { arms: [
  { arm: 'Grid', after: { posterior: beta(5), lane: beta(6) } },
  { arm: 'SAP', before: { posterior: beta(2), live: beta(2) }, after: { posterior: beta(3), live: beta(4), lane: beta(7) } },
] });

it('shows windows and visits of an arm in two rows', () => {
  expect(measuredRows(SCENE).map(({ label, measured, isPart, posterior: { alpha } }) => [label, measured, isPart, alpha])).toEqual(
    [['Grid lane', 'lane', undefined, 6], ['SAP live', 'live', true, 4], ['SAP lane', 'lane', true, 7]]);
});

it('shows the evidence of the other builds behind that of all builds', () => {
  expect(priorRows(SCENE).map(({ arm, measured, posterior, before }) => [arm, measured, posterior.alpha, before?.alpha])).toEqual(
    [['Grid', 'lane', 5, undefined], ['SAP', 'live', 3, 2]]);
});

it('has no rows for a scene without evidence', () => expect([measuredRows(undefined), priorRows(undefined)]).toEqual([[], []]));
