// `below` is the value of the distribution function at x, from mpmath 1.3.0 with 50 digits: betainc(alpha, beta, 0, x, regularized=True).
import { describe, expect, it } from 'vitest';
import { centralInterval, logitDeviation, logitMode, mean, quantiles, rewardAt, ridge, ridgeAxis } from './beta';

const VALUES: readonly (readonly [alpha: number, beta: number, x: number, below: number])[] = [
  [2, 5, 0.2058547150892932, 0.359026007096762],
  [2, 5, 0.5987638025642563, 0.958467420062915],
  [12.5, 3, 0.6119281647885395, 0.0400203511043266],
  [1, 1, 0.35566243270259357, 0.355662432702594],
  [2500, 7000, 0.25412263262992413, 0.0221480055199948],
  [5000, 4000, 0.5658211281590345, 0.975135465017205],
  [1e6, 3e6, 0.2504243523948103, 0.974970161816596],
  [1e12, 2e12, 0.33333278900227936, 0.0227501099024751],
  [1e12, 1e12, 0.5, 0.5],
  [4, 1e9, 2.9999999905000002e-9, 0.352768111105748],
];
const logitOf = (x: number) => Math.log(x) - Math.log1p(-x);

describe('quantiles for drawing', () => {
  it.each(VALUES)('of Beta(%d, %d) are at %d, within a hundredth of a standard deviation', (alpha, beta, x, below) => {
    const posterior = { alpha, beta };
    const [found] = quantiles(posterior, [below]);
    expect(Math.abs(logitOf(found!) - logitOf(x)) / logitDeviation(posterior)).toBeLessThan(0.01);
  });

  it('ascend, and lie on both sides of the mean', () => {
    for (const posterior of [{ alpha: 1, beta: 1 }, { alpha: 1, beta: 1e9 }, { alpha: 4e11, beta: 6e11 }, { alpha: 30, beta: 10 }]) {
      const all = quantiles(posterior, [0.001, 0.025, 0.25, 0.75, 0.975, 0.999]);
      expect(all.every((each, i) => each > (all[i - 1] ?? 0) && each < 1)).toBe(true);
      const [low, high] = centralInterval(posterior, 0.95);
      expect([low / all[1]!, high / all[4]!]).toEqual([expect.closeTo(1, 12), expect.closeTo(1, 12)]);
      expect(low < mean(posterior) && mean(posterior) < high).toBe(true);
    }
  });

  it('of a flat density equal their probabilities', () => {
    quantiles({ alpha: 1, beta: 1 }, [0.025, 0.5, 0.975]).forEach((each, i) => expect(Math.abs(each - [0.025, 0.5, 0.975][i]!)).toBeLessThan(1e-3));
  });
});

it('the mode of the logits is at the mean', () => expect(rewardAt(logitMode({ alpha: 30, beta: 10 }))).toBeCloseTo(0.75, 12));
describe('the outline of a density', () => {
  it.each([[1, 1], [1, 40], [3, 9], [1e6, 2e6], [1e12, 5e11]])('of Beta(%d, %d) is finite, between 0 and 1, and ascends', (alpha, beta) => {
    const points = ridge({ alpha, beta }, 0, 1, 100);
    expect(points.every(({ height }) => Number.isFinite(height) && height >= 0 && height <= 1)).toBe(true);
    expect(points.every(({ reward }, i) => i === 0 || reward >= points[i - 1]!.reward)).toBe(true);
    expect(Math.max(...points.map(({ height }) => height))).toBeCloseTo(1, 6);
  });

  it('of α = 1e12 resolves the narrow peak, which evenly spaced points would miss', () => {
    const posterior = { alpha: 1e12, beta: 5e11 };
    const needle = ridge(posterior, 0, 1, 100).filter(({ height }) => height > 0.01);
    expect(needle.length).toBeGreaterThan(10);
    expect(Math.abs(needle[Math.floor(needle.length / 2)]!.reward - mean(posterior))).toBeLessThan(1e-6);
  });

  it('of Beta(1, 1) is flat', () => {
    for (const { height } of ridge({ alpha: 1, beta: 1 }, 0, 1, 50)) expect(height).toBeCloseTo(1, 9);
  });
});

describe('the axis of several densities', () => {
  it('contains measured posteriors, and ignores those without evidence', () => {
    const [low, high] = ridgeAxis([{ posterior: { alpha: 6e5, beta: 4e5 }, isMeasured: true }, { posterior: { alpha: 1, beta: 1 }, isMeasured: false }]);
    expect(low).toBeGreaterThan(0.59);
    expect(high).toBeLessThan(0.61);
  });
  it('is [0, 1] if nothing was measured', () => expect(ridgeAxis([{ posterior: { alpha: 1, beta: 1 }, isMeasured: false }])).toEqual([0, 1]));
});
