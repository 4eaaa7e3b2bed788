import { describe, expect, it } from 'vitest';
import { logitMode, mean, rewardAt, ridge, ridgeAxis } from './beta';

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
