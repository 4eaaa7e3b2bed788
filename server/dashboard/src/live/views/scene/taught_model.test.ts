import { expect, it } from 'vitest';
import type { Taught } from '../../numbers/priors_diff';
import { buildsIn, measuredRows, priorRows } from './taught_model';

const NAME = { project: 'p', scene: 's', machineClass: 'pc', rewardVersion: 3 };

function taught(build: string, arm: string, alpha: number, beta: number, more: Partial<Taught['example']> = {}): Taught {
  return { example: { ...NAME, build, arm, backendVersion: 1, measuredBy: '', ...more }, alpha, beta, bailOutCount: 0 };
}

it('has a row per arm and way of measuring, of all builds together', () => {
  const rows = measuredRows([taught('1', 'SAP', 3, 1), taught('2', 'SAP', 4, 2), taught('2', 'SAP', 9, 9, { measuredBy: 'lane' }), taught('2', 'Grid', 5, 5, { measuredBy: 'lane' })], NAME);
  expect(rows.map(({ label, measured, isPart, posterior: { alpha, beta } }) => [label, measured, isPart, alpha, beta])).toEqual(
    [['Grid lane', 'lane', undefined, 6, 6], ['SAP live', 'live', true, 8, 4], ['SAP lane', 'lane', true, 10, 10]]);
});

it('leaves out other machines, other rewards and old versions of an arm', () => {
  const all = [taught('1', 'SAP', 3, 1), taught('2', 'SAP', 4, 2, { backendVersion: 2 }), taught('3', 'SAP', 9, 9, { machineClass: 'phone' }), taught('4', 'SAP', 9, 9, { rewardVersion: 1 })];
  expect(measuredRows(all, NAME).map(({ posterior }) => posterior)).toEqual([{ alpha: 5, beta: 3 }]);
  expect(buildsIn(all, NAME)).toEqual(['2']);
});

it('sets what all builds taught against what those without the one did', () => {
  const all = [taught('1', 'SAP', 3, 1), taught('2', 'SAP', 4, 2), taught('2', 'Grid', 5, 5)];
  expect(priorRows(all, NAME, '2')).toEqual([
    { arm: 'Grid', label: 'Grid', measured: 'live', posterior: { alpha: 6, beta: 6 } }, // the others know nothing of it
    { arm: 'SAP', label: 'SAP', measured: 'live', posterior: { alpha: 8, beta: 4 }, before: { alpha: 4, beta: 2 } },
  ]);
  expect(priorRows(all, NAME, '1').find(({ arm }) => arm === 'SAP')?.before).toEqual({ alpha: 5, beta: 3 });
});

it('has a prior of visits only where nothing ran in a game', () => {
  const [row] = priorRows([taught('1', 'SAP', 60, 40, { measuredBy: 'lane' }), taught('2', 'SAP', 3, 1, { measuredBy: 'lane' })], NAME, '2');
  expect(row?.measured).toBe('lane');
  const { alpha, beta } = row!.before!;
  expect((alpha - 1) / (alpha + beta - 2)).toBeCloseTo(0.6, 10);
  expect(alpha + beta - 2).toBeLessThan(100); // the lane's bias is in it
});
