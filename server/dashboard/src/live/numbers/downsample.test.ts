import { describe, expect, it } from 'vitest';
import { keepExtremes } from './downsample';

const count = 100_000;
const x = Array.from({ length: count }, (_, i) => i * 0.5);
// Deterministic noise.
const noise = x.map((_, i) => Math.sin(i * 12.9898) * 0.5);

describe('keeping extremes', () => {
  it('keeps the highest and lowest value of every range, including spikes', () => {
    const spiky = noise.map((value, i) => (i === 31_337 ? 50 : i === 70_001 ? -50 : value));
    const kept = keepExtremes(x, [spiky], 400);
    expect(kept.length).toBeLessThanOrEqual(400);
    expect(kept).toContain(31_337);
    expect(kept).toContain(70_001);
    expect([kept[0], kept.at(-1)]).toEqual([0, count - 1]);
  });

  it('keeps the extremes of each of several columns', () => {
    const a = noise.map((value, i) => (i === 500 ? 9 : value));
    const b = noise.map((value, i) => (i === 90_000 ? -9 : value));
    const kept = keepExtremes(x, [a, b], 100);
    expect(kept.length).toBeLessThanOrEqual(100);
    expect(kept).toContain(500);
    expect(kept).toContain(90_000);
  });

  it('keeps all points in their order if they are few', () => expect(keepExtremes([1, 2, 3], [[3, 1, 2]], 8)).toEqual([0, 1, 2]));

  it('skips missing values, and accepts uneven steps of x', () => {
    const uneven = [0, 1, 2, 3, 1000, 1001, 1002, 1003, 1004, 1005];
    const kept = keepExtremes(uneven, [[null, 5, null, 1, null, 7, 2, 3, null, 4]], 6);
    expect(kept).toEqual(expect.arrayContaining([1, 3, 5, 6]));
    expect([...kept]).toEqual([...kept].sort((a, b) => a - b));
  });
});
