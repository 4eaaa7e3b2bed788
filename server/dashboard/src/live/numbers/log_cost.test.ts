import { expect, it } from 'vitest';
import { beliefOf, costNsOf, costRatioOf, evidenceOf, rewardOfNs } from './log_cost';

it('A reward of 1 is a nanosecond, a reward of 0 is five seconds', () => {
  expect(costNsOf(1)).toBe(1);
  expect(costNsOf(0)).toBeCloseTo(5e9, -2);
  expect(rewardOfNs(costNsOf(0.61))).toBeCloseTo(0.61, 12);
});

it('A belief has the mean and variance of the posterior on the scale of log-costs', () => {
  const { mean, variance } = beliefOf({ alpha: 6e5, beta: 4e5 });
  expect(mean).toBeCloseTo(0.4 * Math.log(5e9), 9);
  expect(variance).toBeCloseTo((0.24 / (1e6 + 1)) * Math.log(5e9) ** 2, 12);
});

it('A cost ratio has its median between its bounds, and is 1 for equal arms', () => {
  const equal = costRatioOf({ alpha: 600, beta: 400 }, { alpha: 600, beta: 400 });
  expect(equal.median).toBe(1);
  expect(equal.low * equal.high).toBeCloseTo(1, 9);
  const dearer = costRatioOf({ alpha: 5.5e8, beta: 4.5e8 }, { alpha: 6e8, beta: 4e8 });
  expect(dearer.median).toBeCloseTo(Math.exp(0.05 * Math.log(5e9)), 6);
  expect(dearer.low).toBeGreaterThan(1);
});

it('evidenceOf inverts the variance of beliefOf, and returns at least one', () => {
  const n = evidenceOf(0.6, 0.15 ** 2);
  expect(beliefOf({ alpha: 0.6 * (n - 1), beta: 0.4 * (n - 1) }).variance).toBeCloseTo(0.15 ** 2, 12);
  expect(evidenceOf(0.6, 1e9)).toBe(1);
  expect(evidenceOf(0.6, 0)).toBe(1e12);
});
