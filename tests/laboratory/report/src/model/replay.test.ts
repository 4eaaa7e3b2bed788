import { expect, test } from 'vitest';
import { calibrationError, reliabilityOf, type ReplayDocument, type ReplayRow } from './replay';

const bin = (low: number, decisions: number, predicted: number, best: number) => ({ low, high: low + 0.1, decisions, predicted, best, best_or_tie: 1 });
const row = (policy: string, reliability: ReplayRow['reliability']) => ({ policy, reliability }) as ReplayRow;
const documentOf = (rows: ReplayRow[]): ReplayDocument => ({ command: 'replay', seeds: 1, rows });

test('the bins of all traces are one, weighted by their decisions', () => {
  const document = documentOf([row('default', [bin(0.8, 1, 0.81, 0), bin(0.5, 4, 0.55, 0.5)]), row('default', [bin(0.8, 3, 0.85, 1)]),
    row('paper', [bin(0.8, 9, 0.9, 0)]), row('oracle', undefined)]);
  const bins = reliabilityOf(document, 'default');
  expect(bins.map(({ low, decisions }) => [low, decisions])).toEqual([[0.5, 4], [0.8, 4]]);
  expect(bins[1]!.predicted).toBeCloseTo(0.84);
  expect(bins[1]!.best).toBeCloseTo(0.75);
  expect(bins[1]!.best_or_tie).toBe(1);
  expect(reliabilityOf(document, 'oracle')).toEqual([]);
});

test('the error is the mean distance over the decisions', () => {
  expect(calibrationError([bin(0.5, 1, 0.5, 1), bin(0.8, 3, 0.8, 0.6)])).toBeCloseTo((0.5 + 3 * 0.2) / 4);
});
