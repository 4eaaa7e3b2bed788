// The values for a few arms are integrals by mpmath 1.3.0 with 18 digits, of the product of the densities and distribution functions:
//
//   from mpmath import *
//   mp.dps = 18
//   def best(arms):
//       cdf = lambda a, b, x: betainc(a, b, 0, x, regularized=True)
//       p = [quad(lambda x: x**(a - 1) * (1 - x)**(b - 1) / beta(a, b) * fprod(cdf(c, d, x) for j, (c, d) in enumerate(arms) if j != i),
//                 linspace(0, 1, 21)) for i, (a, b) in enumerate(arms)]
//       return p, quad(lambda x: 1 - fprod(cdf(c, d, x) for c, d in arms), linspace(0, 1, 21))
//
// Those of two narrow arms are sums of the density of one times the distribution function of the other, with 40 digits and steps of an
// eighth of the narrower one's deviation, the distribution function by the trapezoidal rule with Euler's and Maclaurin's first term.
import { describe, expect, it } from 'vitest';
import { bestProbabilities, diagnose, diagnoseLogCosts, expectedLoss } from './best';
import type { Beta } from './beta';

const arms = (...all: [number, number][]): Beta[] => all.map(([alpha, beta]) => ({ alpha, beta }));
const sum = (values: number[]) => values.reduce((total, value) => total + value, 0);

describe('the probability to be the best', () => {
  it.each([
    [arms([2, 5], [3, 4], [1, 1]), [0.117882117882, 0.351648351648, 0.53046953047]],
    [arms([30, 20], [28, 22], [5, 9], [1.5, 2]), [0.494307855284, 0.249164060828, 0.0241248404518, 0.232403243436]],
  ])('is that of mpmath', (posteriors, expected) => {
    bestProbabilities(posteriors).forEach((p, i) => expect(Math.abs(p - expected[i]!)).toBeLessThan(2e-6));
  });

  it.each([
    [1e12, 1e12, 1e12 + 1e6, 1e12 - 1e6, 0.158655294978],
    [4e8, 6e8, 4.0005e8, 5.9995e8, 0.011240125413],
    [5000, 4000, 5050, 3950, 0.226470183064],
  ])('of Beta(%d, %d) against Beta(%d, %d) is that of mpmath', (a, b, c, d, expected) => {
    expect(Math.abs(bestProbabilities(arms([a, b], [c, d]))[0]! - expected)).toBeLessThan(2e-6);
  });

  it('is equal for 32 equal arms, whatever they know', () => {
    for (const size of [2, 1e3, 1e12]) {
      const all = bestProbabilities(Array.from({ length: 32 }, () => ({ alpha: size, beta: size })));
      for (const p of all) expect(Math.abs(p - 1 / 32)).toBeLessThan(2e-6);
      expect(sum(all)).toBeCloseTo(1, 12);
    }
  });

  it('of a needle among wide arms is the share of each that is above it', () => {
    const [needle, ...wide] = bestProbabilities(arms([6e11, 4e11], [1, 1], [1, 1]));
    expect(needle).toBeCloseTo(0.36, 5); // both others are below 0.6
    expect(wide[0]).toBeCloseTo(0.32, 5);
  });

  it('is certain where arms are far apart, on both sides of one half', () => {
    expect(bestProbabilities(arms([9e11, 1e11], [1e11, 9e11]))).toEqual([1, 0]);
    expect(bestProbabilities(arms([3e4, 7e6], [1e4, 9e6]))[0]).toBeCloseTo(1, 9);
  });

  it('is not there where nothing is learnt', () => expect(bestProbabilities(arms([1, 1], [1, 1]))).toEqual([]));
});

describe('the expected loss', () => {
  it('of the leader is that of mpmath', () => {
    // The expected best reward is 0.622502497502; the leader is Beta(1, 1).
    expect(expectedLoss(arms([2, 5], [3, 4], [1, 1]))).toBeCloseTo((0.622502497502 - 0.5) / 0.622502497502, 6);
    expect(expectedLoss(arms([30, 20], [28, 22], [5, 9], [1.5, 2]))).toBeCloseTo((0.655665735286 - 0.6) / 0.655665735286, 6);
  });

  it('goes to nothing as arms become known', () => {
    const losses = [10, 1e4, 1e6, 1e7].map((n) => expectedLoss(arms([0.6 * n, 0.4 * n], [0.599 * n, 0.401 * n])));
    for (let i = 1; i < losses.length; ++i) expect(losses[i]!).toBeLessThan(losses[i - 1]!);
    expect(expectedLoss(arms([6e11, 4e11], [5.99e11, 4.01e11]))).toBeLessThan(1e-12);
  });

  it('of what is remaining is nothing for the arm with the best mean where it leads', () => {
    const { valueRemainingRatio, expectedLossRatio } = diagnose(arms([30, 20], [28, 22]));
    expect(valueRemainingRatio).toBeCloseTo(expectedLossRatio, 12);
  });
});

describe('normal log-costs', () => {
  it('have the probability of a normal difference', () => {
    // The difference has mean 0.1 and deviation 0.1: Φ(1).
    const { bestProbability, leader } = diagnoseLogCosts([{ mean: 2.1, variance: 0.005 }, { mean: 2, variance: 0.005 }]);
    expect(leader).toBe(1);
    expect(bestProbability[1]).toBeCloseTo(0.841344746, 6);
  });

  it('lose exp(E[leader − best]) − 1', () => {
    // E[max(d, 0)] of a normal d of mean −0.1 and deviation 0.1 is 0.1 (φ(1) − (1 − Φ(1))) = 0.00833155.
    const { expectedLossRatio } = diagnoseLogCosts([{ mean: 2.1, variance: 0.005 }, { mean: 2, variance: 0.005 }]);
    expect(expectedLossRatio).toBeCloseTo(Math.expm1(0.1 * (0.24197072451914337 - 0.15865525393145707)), 7);
  });
});
