import { expect, it } from 'vitest';
import { ratioAxis } from './intervals';

it('An axis of ratios shows medians and intervals, and cuts off very wide intervals', () => {
  const [low, high] = ratioAxis([{ median: 1, low: 1, high: 1 }, { median: 2, low: 1.5, high: 3 }]);
  expect([low, high]).toEqual([expect.closeTo(1 / 3 ** 0.05, 12), expect.closeTo(3 * 3 ** 0.05, 12)]);
  const wide = ratioAxis([{ median: 1, low: 1, high: 1 }, { median: 2, low: 1e-6, high: 1e6 }]);
  expect(wide[0]).toBeGreaterThan(0.05);
  expect(wide[1]).toBeLessThan(30);
  const [least, most] = ratioAxis([{ median: 1, low: 1, high: 1 }]);
  expect(most).toBeGreaterThan(least);
});
