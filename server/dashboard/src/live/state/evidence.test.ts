import { create } from '@bufbuild/protobuf';
import { expect, it } from 'vitest';
import { ExportPriorsResponseSchema } from '../../gen/sweepstake/v1/priors_pb';
import { addPart, noEvidence, priorsFile } from './evidence';

const recordOf = (sourceId: string, more: { arm?: string; measuredBy?: string; bailOutCount?: bigint; build?: string; unixLastSeenS?: bigint } = {}) => ({ project: 'p', scene: 's', arm: 'SAP', backendVersion: 1, rewardVersion: 3,
  sourceId, sourceSequence: 7n, alphaIncrement: 1.5, betaIncrement: 0.5, windowCount: 2n, ...more });

function evidenceOf(...parts: Parameters<typeof create<typeof ExportPriorsResponseSchema>>[1][]) {
  const evidence = noEvidence();
  for (const part of parts) addPart(evidence, create(ExportPriorsResponseSchema, part));
  return evidence;
}

it('sums what sources taught by scene and arm, and by source', () => {
  const evidence = evidenceOf(
    { records: [recordOf('x'), recordOf('y'), recordOf('x', { arm: 'Grid', bailOutCount: 1n })] },
    { records: [recordOf('x', { measuredBy: 'lane' })], foldedRecordCount: 4n, foldedWindowCount: 40n });
  expect(evidence.sums.size).toBe(3);
  expect([...evidence.sums.values()][0]).toMatchObject({ sourceCount: 2, alpha: 3, beta: 1, windowCount: 4, bailOutCount: 0 });
  expect(evidence.sources.get('x')).toMatchObject({ windowCount: 6, bailOutCount: 1, arms: new Set(['SAP', 'Grid']) });
  expect(evidence).toMatchObject({ recordCount: 4, foldedRecordCount: 4, foldedWindowCount: 40 });
});

it('writes the file that is imported', () => {
  const { records } = evidenceOf({ records: [recordOf('x', { build: '1.1', unixLastSeenS: 1_700_000_000n })] });
  expect(JSON.parse(priorsFile(records))).toEqual({ format: 'sweepstake-priors', version: 1, records: [{
    project: 'p', scene: 's', measured_by: '', arm: 'SAP', backend_version: 1, machine_class: '', reward_version: 3, source_id: 'x',
    source_sequence: 7, alpha_increment: 1.5, beta_increment: 0.5, window_count: 2, bail_out_count: 0, build: '1.1',
    unix_last_seen_s: 1_700_000_000 }] });
});
