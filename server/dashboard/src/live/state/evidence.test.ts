import { create } from '@bufbuild/protobuf';
import { expect, it } from 'vitest';
import { ExportPriorsResponseSchema } from '../../gen/sweepstake/v1/priors_pb';
import { addPart, MAX_SOURCES, noEvidence, priorsFile } from './evidence';

interface More { arm?: string; measuredBy?: string; bailOutCount?: bigint; build?: string; unixLastSeenS?: bigint; isImported?: boolean; isQuarantined?: boolean; machineClass?: string; weight?: number }
const recordOf = (sourceId: string, more: More = {}) => ({ project: 'p', scene: 's', arm: 'SAP', backendVersion: 1, rewardVersion: 3,
  sourceId, sourceSequence: 7n, alphaIncrement: 1.5, betaIncrement: 0.5, windowCount: 2n, ...more });

function evidenceOf(...parts: Parameters<typeof create<typeof ExportPriorsResponseSchema>>[1][]) {
  const evidence = noEvidence();
  for (const part of parts) addPart(evidence, create(ExportPriorsResponseSchema, part));
  return evidence;
}

it('sums evidence by scene and arm, and by source', () => {
  const evidence = evidenceOf(
    { records: [recordOf('x'), recordOf('y'), recordOf('x', { arm: 'Grid', bailOutCount: 1n, weight: 0.5 })] },
    { records: [recordOf('x', { measuredBy: 'lane', weight: 0.02 })] });
  expect(evidence.sums.size).toBe(3);
  expect([...evidence.sums.values()][0]).toMatchObject({ sourceCount: 2, alpha: 3, beta: 1, windowCount: 4, bailOutCount: 0 });
  expect(evidence.sources.get('x')).toMatchObject({ windowCount: 6, bailOutCount: 1, weight: 0.5, arms: new Set(['SAP', 'Grid']) });
  expect(evidence).toMatchObject({ recordCount: 4 });
});

it('keeps builds apart, and sums counts, arms, machines and times of each build and source', () => {
  const evidence = evidenceOf({ records: [
    recordOf('x', { build: '1.1', unixLastSeenS: 50n, machineClass: 'desktop' }), recordOf('y', { build: '1.2', unixLastSeenS: 70n }),
    recordOf('z', { build: '1.1', unixLastSeenS: 60n, arm: 'Grid', isImported: true }), recordOf('x', { build: '1.1', unixLastSeenS: 50n, measuredBy: 'lane' }),
  ] });
  expect([...evidence.sums.values()].map(({ example, alpha }) => [example.build, example.arm, alpha])).toEqual(
    [['1.1', 'SAP', 1.5], ['1.2', 'SAP', 1.5], ['1.1', 'Grid', 1.5], ['1.1', 'SAP', 1.5]]);
  expect([...evidence.builds.values()].map(({ build, sourceIds, windowCount, lastSeenS }) => [build, sourceIds.size, windowCount, lastSeenS])).toEqual(
    [['1.1', 2, 6, 60], ['1.2', 1, 2, 70]]);
  expect([...evidence.builds.values()][0]).toMatchObject({ project: 'p', arms: new Set(['SAP', 'Grid']), machineClasses: new Set(['desktop', '']) });
  expect([...evidence.sources.values()].map(({ sourceId, build, isImported, lastSeenS }) => [sourceId, build, isImported, lastSeenS])).toEqual(
    [['x', '1.1', false, 50], ['y', '1.2', false, 70], ['z', '1.1', true, 60]]);
});

it('keeps quarantined records apart, and writes them into the file', () => {
  const evidence = evidenceOf({ records: [recordOf('x', { build: '1.1' }), recordOf('x', { build: '1.1', isQuarantined: true }),
    recordOf('y', { build: '0.9', isQuarantined: true, unixLastSeenS: 60n }), recordOf('z', { build: '0.9', isQuarantined: true })] });
  expect([...evidence.sums.values()].map(({ alpha }) => alpha)).toEqual([1.5]);
  expect([[...evidence.sources.keys()], [...evidence.builds.keys()]]).toEqual([['x'], ['p\n1.1']]);
  expect(evidence).toMatchObject({ recordCount: 1, waitingCount: 3 });
  expect([...evidence.waiting.values()].map(({ build, sourceIds, windowCount, lastSeenS }) => [build, sourceIds.size, windowCount, lastSeenS])).toEqual(
    [['1.1', 1, 2, 0], ['0.9', 2, 4, 60]]);
  const { records } = JSON.parse(priorsFile(evidence.records)) as { records: { is_quarantined?: boolean }[] };
  expect(records.map(({ is_quarantined: waits }) => waits)).toEqual([undefined, true, true, true]);
});

it('is bounded, and reports that records were left out', () => {
  const many = Array.from({ length: MAX_SOURCES + 1 }, (_, i) => recordOf(`source ${i}`, { build: `build ${i}` }));
  expect(evidenceOf({ records: many.slice(1) }).isCut).toBe(false);
  const evidence = evidenceOf({ records: many });
  expect(evidence).toMatchObject({ isCut: true, recordCount: MAX_SOURCES + 1 });
  expect([evidence.sources.size, evidence.builds.size, evidence.sums.size]).toEqual([MAX_SOURCES, MAX_SOURCES, MAX_SOURCES + 1]);
});

it('writes the file format of `sweepstake priors import`', () => {
  const { records } = evidenceOf({ records: [recordOf('x', { build: '1.1', unixLastSeenS: 1_700_000_000n })] });
  expect(JSON.parse(priorsFile(records))).toEqual({ format: 'sweepstake-priors', version: 1, records: [{
    project: 'p', scene: 's', measured_by: '', arm: 'SAP', backend_version: 1, machine_class: '', reward_version: 3, source_id: 'x',
    source_sequence: 7, alpha_increment: 1.5, beta_increment: 0.5, window_count: 2, bail_out_count: 0, build: '1.1',
    unix_last_seen_s: 1_700_000_000 }] });
});
