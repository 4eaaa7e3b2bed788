import { expect, it } from 'vitest';
import { axisTime, usualOf, valueRange } from './plot';

const budget = { value: 16, label: '60 fps' };

it('An axis reaches its levels, except those that are marked isAside', () => {
  expect(valueRange({ scale: 'zero', levels: [budget] }, 0, 0.05)[1]).toBeCloseTo(16 * 1.15, 12);
  const aside = { scale: 'zero' as const, levels: [{ ...budget, isAside: true }] };
  expect(valueRange(aside, 0, 0.05)[1]).toBeCloseTo(0.05 * 1.08, 12);
  expect(valueRange(aside, 0, 15.9)[1], 'the level is drawn if values come near it').toBeGreaterThan(16);
  expect(valueRange({ ...aside, values: [0, 20] }, 0, 0.05)[1], 'a range shared with other charts').toBeCloseTo(20 * 1.08, 12);
  expect(valueRange(aside, null, null)).toEqual([0, 1]);
});

it('An axis from 0 does not reach outliers', () => {
  const values = Array.from({ length: 200 }, (_, i) => (i === 150 ? 300 : i % 17));
  const picture = { timesMs: values.map((_, i) => i), lines: [{ label: '', values, colour: '' }], domain: { fromMs: 0, toMs: 199 }, hidden: new Set<string>() };
  expect(usualOf(picture)).toBe(16);
  expect(valueRange({ scale: 'zero' }, 0, 300, 16)[1]).toBeCloseTo(2 * 16 * 1.08, 12);
  expect(valueRange({ scale: 'zero' }, 0, 39, 16)[1], 'a peak that fits').toBeCloseTo(39 * 1.08, 12);
  expect(valueRange({ scale: 'zero', values: [0, 300] }, 0, 300, 16)[1], 'a range shared with other charts').toBeCloseTo(300 * 1.08, 12);
  expect(usualOf({ ...picture, domain: { fromMs: 150, toMs: 150 } }), 'only shown values count').toBe(300);
  expect(usualOf({ ...picture, lines: [] })).toBeUndefined();
  const few = { ...picture, lines: [{ label: '', values: [...values.slice(0, 49), 300], colour: '' }] };
  expect(usualOf(few), 'one outlier among 50 values').toBe(16);
});

it('A logarithmic axis ends at the next round values', () => {
  const range = (min: number, max: number) => valueRange({ scale: 'log' }, min, max).map((value) => Number(value!.toPrecision(9)));
  expect(range(78e3, 180e3)).toEqual([50e3, 200e3]);
  expect(range(0.001, 50)).toEqual([0.001, 50]);
  expect(range(1, 1), 'the axis is never empty').toEqual([1, 2]);
  expect(range(0, 0)).toEqual([1, 10]);
});

it('The times on an axis are rounded to whole seconds, and as short as its steps allow', () => {
  const noonMs = new Date(2026, 10, 25, 12, 0, 0).getTime();
  expect([noonMs, noonMs - 0.2, noonMs + 0.2].map((ms) => axisTime(ms, 60_000))).toEqual(['12:00', '12:00', '12:00']);
  expect([1000, 86_400_000].map((stepMs) => axisTime(noonMs + 999.9, stepMs))).toEqual(['12:00:01', '25 Nov']);
});
