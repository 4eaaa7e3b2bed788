import { describe, expect, it } from 'vitest';
import { linearTicks, logTicks } from './ticks';

describe('ticks', () => {
  it('are round', () => {
    expect(linearTicks(0.1, 0.52, 4)).toEqual([0.2, 0.4]);
    expect(logTicks(900, 120_000, 9)).toEqual([1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000]);
    expect(logTicks(900, 120_000, 4)).toEqual([1000, 10_000, 100_000]);
  });
});
