import { expect, it } from 'vitest';
import { costNsOf, nsText, rewardOfNs } from './log_cost';

it('A reward of 1 is a nanosecond, a reward of 0 is five seconds', () => {
  expect(costNsOf(1)).toBe(1);
  expect(costNsOf(0)).toBeCloseTo(5e9, -2);
  expect(rewardOfNs(costNsOf(0.61))).toBeCloseTo(0.61, 12);
});

it('a time is in its own unit, or in that of another time', () => {
  expect(nsText(306)).toBe('306 ns');
  expect(nsText(306, 1950)).toBe('0.306 µs');
  expect(nsText(1950)).toBe('1.95 µs');
});
