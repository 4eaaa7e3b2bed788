import { create, type Init } from '../transport/messages';
import { expect, it } from 'vitest';
import { type PriorRecord, PriorRecordSchema } from '../../gen/sweepstake/v1/priors_pb';
import { groupsOf, mostOf, namesOf, priorsFile, sumOf } from './evidence';

const recordOf = (sourceId: string, more: Init<PriorRecord> = {}) =>
  create(PriorRecordSchema, { project: 'p', scene: 's', arm: 'SAP', backendVersion: 1, rewardVersion: 3, sourceId, sourceSequence: 7n,
    alphaIncrement: 1.5, betaIncrement: 0.5, windowCount: 2n, ...more });

it('sums evidence by arm, by source and by build', () => {
  const records = [
    recordOf('x', { build: '1.1', unixLastSeenS: 50n, machineClass: 'desktop', weight: 0.02 }), recordOf('y', { build: '1.2', unixLastSeenS: 70n }),
    recordOf('z', { build: '1.1', unixLastSeenS: 60n, arm: 'Grid' }), recordOf('x', { build: '1.1', measuredBy: 'lane', weight: 0.5 }),
  ];
  const [alpha, windows, weight, seen] = [sumOf('alphaIncrement'), sumOf('windowCount'), mostOf('weight'), mostOf('unixLastSeenS')];
  expect(groupsOf(records, 'arm', 'measuredBy').map((group) => [group.key, alpha(group), namesOf('sourceId')(group)])).toEqual(
    [['SAP\n', 3, ['x', 'y']], ['Grid\n', 1.5, ['z']], ['SAP\nlane', 1.5, ['x']]]);
  expect(groupsOf(records, 'sourceId').map((group) => [group.key, windows(group), weight(group)])).toEqual([['x', 4, 0.5], ['y', 2, 0], ['z', 2, 0]]);
  expect(groupsOf(records, 'build').map((group) => [group.key, windows(group), seen(group)])).toEqual([['1.1', 6, 60], ['1.2', 2, 70]]);
});

it('writes the file format of `sweepstake priors import`', () => {
  const plain = { project: 'p', scene: 's', measured_by: '', arm: 'SAP', backend_version: 1, machine_class: '', reward_version: 3,
    source_sequence: 7, alpha_increment: 1.5, beta_increment: 0.5, window_count: 2, bail_out_count: 0, build: '', unix_last_seen_s: 0 };
  const records = [recordOf('x', { build: '1.1', unixLastSeenS: 1_700_000_000n }), recordOf('y', { isQuarantined: true, regime: '9/-/0' })];
  expect(JSON.parse(priorsFile(records))).toEqual(
    { format: 'sweepstake-priors', version: 1, records: [
      { ...plain, source_id: 'x', build: '1.1', unix_last_seen_s: 1_700_000_000 }, { ...plain, source_id: 'y', is_quarantined: true, regime: '9/-/0' }] });
});
