import { expect, it } from 'vitest';
import { valueRange } from './plot';

const budget = { value: 16, label: '60 fps' };

it('An axis reaches its levels, but for those that stand aside', () => {
  expect(valueRange({ scale: 'zero', levels: [budget] }, 0, 0.05)[1]).toBeCloseTo(16 * 1.15, 12);
  const aside = { scale: 'zero' as const, levels: [{ ...budget, isAside: true }] };
  expect(valueRange(aside, 0, 0.05)[1]).toBeCloseTo(0.05 * 1.08, 12);
  expect(valueRange(aside, 0, 15.9)[1], 'is drawn where values come near it').toBeGreaterThan(16);
  expect(valueRange({ ...aside, values: [0, 20] }, 0, 0.05)[1], 'of charts beside others').toBeCloseTo(20 * 1.08, 12);
  expect(valueRange(aside, null, null)).toEqual([0, 1]);
});
