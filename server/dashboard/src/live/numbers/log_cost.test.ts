import { expect, it } from 'vitest';
import { costNsOf, rewardOfNs } from './log_cost';

it('A reward of 1 is a nanosecond, a reward of 0 is five seconds', () => {
  expect(costNsOf(1)).toBe(1);
  expect(costNsOf(0)).toBeCloseTo(5e9, -2);
  expect(rewardOfNs(costNsOf(0.61))).toBeCloseTo(0.61, 12);
});
