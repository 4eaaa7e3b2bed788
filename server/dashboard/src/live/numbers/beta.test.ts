// The values are those of mpmath 1.3.0 with 50 digits, to 15 of them: the integral of the density on the scale of logits, and its logarithm.
//
//   from mpmath import *
//   mp.dps = 50
//   def row(a, b, x):
//       logb = loggamma(a) + loggamma(b) - loggamma(a + b)
//       f = lambda t: exp(a * t - (a + b) * log1p(exp(t)) - logb)
//       mode, s, end = log(a / b), sqrt((a + b) / (a * b)), log(x / (1 - x))
//       low = min(mode, end) - 40 * s * (1 + s)
//       return (quad(f, [low + (end - low) * mpf(i) / 60 for i in range(61)]), (a - 1) * log(x) + (b - 1) * log1p(-x) - logb)
//   print(row(mpf(2), mpf(5), mpf(0.2058547150892932)))
import { describe, expect, it } from 'vitest';
import { cdf, centralInterval, logDensity, logGamma, mean, quantile } from './beta';

const VALUES: readonly (readonly [alpha: number, beta: number, x: number, below: number, logDensity: number])[] = [
  [2, 5, 0.2058547150892932, 0.359026007096762, 0.898657332109076],
  [2, 5, 0.5987638025642563, 0.958467420062915, -0.764510712735581],
  [0.5, 0.5, 0.32322330470336313, 0.384973271918692, -0.384817008977194],
  [12.5, 3, 0.6119281647885395, 0.0400203511043266, -0.431824213066506],
  [12.5, 3, 0.9970845920556183, 0.999990145502656, -4.59964740537193],
  [1, 1, 0.35566243270259357, 0.355662432702594, 0],
  [2500, 7000, 0.25412263262992413, 0.0221480055199948, 2.47334179128567],
  [2500, 7000, 0.2720124516016217, 0.974397352556012, 2.56601671328908],
  [5000, 4000, 0.545080481470373, 0.0228742730734565, 2.33466456021479],
  [5000, 4000, 0.5658211281590345, 0.975135465017205, 2.41100571342395],
  [1e6, 3e6, 0.24956698735223437, 0.0227189444868746, 5.51856698501955],
  [1e6, 3e6, 0.2504243523948103, 0.974970161816596, 5.59846943568137],
  [1e12, 2e12, 0.33333278900227936, 0.0227501099024751, 12.1979165951694],
  [1e12, 2e12, 0.3333331972505698, 0.308537574616167, 14.0729170545355],
  [1e12, 2e12, 0.33333386677776616, 0.975002082243964, 12.277117092262],
  [1e12, 1e12, 0.4999992928932188, 0.0227501319485757, 11.9362927956156],
  [1e12, 1e12, 0.5, 0.5, 13.9362927955994],
  [1e12, 1e12, 0.5000006929646456, 0.975002104850439, 12.0154927956458],
  [4, 1e9, 9.99999983775159e-18, 4.16666638791932e-34, -36.3305359168133],
  [4, 1e9, 2.9999999905000002e-9, 0.352768111105748, 19.2273432382227],
  [4, 1e9, 7.91999995852e-9, 0.955271697460078, 17.219679993522],
];
const nearTo = (value: number, expected: number, relative: number) => Math.abs(value - expected) <= relative * Math.abs(expected);

describe('the Beta distribution', () => {
  it.each(VALUES)('Beta(%d, %d) at %d has the distribution function of mpmath', (alpha, beta, x, below) => {
    expect(nearTo(cdf({ alpha, beta }, x), below, 1e-8)).toBe(true); // at 1e12 the rounding of a logit alone is worth 1e-9
    expect(cdf({ alpha: beta, beta: alpha }, 1 - x)).toBeCloseTo(1 - below, 7); // 1 − x has lost digits
  });

  it.each(VALUES)('Beta(%d, %d) at %d has the density of mpmath', (alpha, beta, x, _, expected) => {
    expect(Math.abs(logDensity({ alpha, beta }, x) - expected)).toBeLessThan(1e-8);
  });

  it.each(VALUES.filter(([, , , below]) => below > 1e-20))('Beta(%d, %d): %d is its own quantile', (alpha, beta, x, below) => {
    const deviation = Math.sqrt((alpha * beta) / (alpha + beta + 1)) / (alpha + beta);
    expect(Math.abs(quantile({ alpha, beta }, below) - x)).toBeLessThan(1e-5 * deviation + 4e-16 * x);
  });

  it('has quantiles that go back through the distribution function, from 1e-6 to 1e12', () => {
    for (const alpha of [1e-3, 0.4, 1, 7, 2999, 3001, 1e5, 1e9, 1e12]) {
      for (const beta of [0.02, 1, 55, 4000, 1e8, 1e12]) {
        for (const p of [0.025, 0.25, 0.5, 0.75, 0.975]) {
          const x = quantile({ alpha, beta }, p);
          if (x > 1e-300 && x < 1 - 1e-9) expect(Math.abs(cdf({ alpha, beta }, x) - p), `Beta(${alpha}, ${beta}) at ${p}`).toBeLessThan(1e-6);
        }
      }
    }
  });

  it('has the known values of Γ', () => {
    expect(logGamma(1)).toBeCloseTo(0, 13);
    expect(logGamma(0.5)).toBeCloseTo(Math.log(Math.PI) / 2, 13);
    expect(logGamma(171)).toBeCloseTo(706.5730622457874, 10);
  });

  it('ends at 0 and 1', () => {
    expect([cdf({ alpha: 3, beta: 4 }, 0), cdf({ alpha: 3, beta: 4 }, 1), quantile({ alpha: 3, beta: 4 }, 0), quantile({ alpha: 3, beta: 4 }, 1)]).toEqual([0, 1, 0, 1]);
  });

  it('has central intervals about the mean', () => {
    const posterior = { alpha: 4e11, beta: 6e11 };
    const [low, high] = centralInterval(posterior, 0.95);
    expect(low).toBeLessThan(mean(posterior));
    expect((high - low) / (2 * 1.959963985 * Math.sqrt(0.24 / 1e12))).toBeCloseTo(1, 5);
  });
});
