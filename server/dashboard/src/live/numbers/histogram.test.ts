import { describe, expect, it } from 'vitest';
import { bucketsOf, middleOf, percentile, percentiles } from './histogram';

describe('histograms of the daemon', () => {
  it('number their buckets by differences', () => {
    expect([...bucketsOf({ bucketSteps: [0, 8, 3], counts: [1, 2, 4] })]).toEqual([[0, 1], [8, 2], [11, 4]]);
  });

  it('have values at most 4.5 % from the middle of their bucket', () => {
    for (const value of [1, 7, 1000, 16_666_667, 1e12]) {
      const bucket = Math.floor(8 * Math.log2(value)) + 1;
      expect(Math.abs(middleOf(bucket) / value - 1)).toBeLessThan(0.0451);
    }
    expect(middleOf(0)).toBe(0);
  });

  it('have percentiles', () => {
    const buckets = bucketsOf({ bucketSteps: [10, 10, 10], counts: [50, 45, 5] });
    expect(percentile(buckets, 0.5)).toBe(middleOf(10));
    expect(percentile(buckets, 0.95)).toBe(middleOf(20));
    expect(percentile(bucketsOf({ bucketSteps: [10, 10, 10], counts: [1, 1, 1] }), 0.5)).toBe(middleOf(20)); // the second of three
    expect(percentiles({ bucketSteps: [10, 10, 10], counts: [50, 45, 5] })).toEqual([middleOf(10), middleOf(20), middleOf(30)]);
  });

  it('have no percentiles if they are empty or break their rules', () => {
    expect(percentile(bucketsOf({ bucketSteps: [], counts: [] }), 0.5)).toBeUndefined();
    expect(percentiles({ bucketSteps: [3], counts: [] })).toBeUndefined();
  });
});
