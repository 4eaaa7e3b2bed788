// `below` is the value of the distribution function at x, from mpmath 1.3.0 with 50 digits: betainc(alpha, beta, 0, x, regularized=True).
import { describe, expect, it } from 'vitest';
import { centralInterval, logitDeviation, logitMode, mean, quantiles, rewardAt } from './beta';

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
