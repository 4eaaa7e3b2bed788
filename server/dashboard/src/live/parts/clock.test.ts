import { expect, it } from 'vitest';
import { ago, clockText, dayText, duration, minuteText, timeText } from './clock';

it('a duration has one unit, which is rounded down', () => {
  expect([-5, 999, 59_999, 60_000, 3_599_999, 86_399_999, 2 * 86_400_000].map(duration)).toEqual(['0 sec', '0 sec', '59 sec', '1 min', '59 min', '23 hr', '2 days']);
  expect([ago(0, 1999), ago(0, 2000)]).toEqual(['now', '2 sec ago']);
});

it('times have a clock of 24 hours, and the day before the month', () => {
  const ms = new Date(2026, 2, 1, 14, 5, 9).getTime();
  expect([timeText, clockText, minuteText, dayText].map((text) => text(ms))).toEqual(['1 Mar 2026, 14:05:09', '14:05:09', '14:05', '1 Mar']);
});
