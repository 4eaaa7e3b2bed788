import { expect, it } from 'vitest';
import { widened } from './widened';

const RANGE = { fromMs: 0, toMs: 100 };

it('A state that is too short is drawn longer, at the cost of the next one', () => {
  expect(widened([0, 50, 51, 80], ['a', 'b', 'a', 'c'], RANGE, 10)).toEqual([0, 50, 60, 80]);
  expect(widened([0, 50, 51, 80], ['a', 'a', 'a', 'c'], RANGE, 10), 'rows of one state keep their times').toEqual([0, 50, 51, 80]);
  expect(widened([0, 50, 51, 55, 58, 80], ['a', 'b', 'a', 'a', 'c', 'c'], RANGE, 10), 'rows stay within their state').toEqual([0, 50, 60, 60, 70, 80]);
});

it('A state at the end of the range is drawn longer, at the cost of the previous one', () => {
  expect(widened([0, 95, 99, 100], ['a', 'a', 'b', 'c'], RANGE, 10)).toEqual([0, 80, 80, 90]);
});

it('States share the range if they do not fit', () => {
  const timesMs = Array.from({ length: 49 }, (_, i) => 90 + i / 5);
  const drawn = widened(timesMs, timesMs.map((_, i) => i % 2), RANGE, 10);
  const lengths = [...drawn.slice(1), 100].map((ms, i) => ms - drawn[i]!);
  for (const length of lengths) expect(length).toBeCloseTo(2, 9);
});

it('Only states within the range count', () => {
  expect(widened([-3, -2, -1, 105, 106], ['a', 'b', 'a', 'b', 'a'], RANGE, 10)).toEqual([-3, -2, -1, 105, 106]);
  expect(widened([-5, 1, 2], ['a', 'b', 'a'], RANGE, 10), 'a state that began before the range is visible, too').toEqual([-5, 10, 20]);
});
