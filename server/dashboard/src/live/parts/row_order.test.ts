import { expect, it } from 'vitest';
import { MAX_GONE, RowOrder, sortedBy } from './row_order';

const keyOf = (row: string) => row[0]!;
const shown = (order: RowOrder<string>, rows: readonly string[], isHeld: boolean) => {
  const { placed, isOutdated } = order.place(rows, keyOf, isHeld);
  return { rows: placed.map(({ row, isGone }) => (isGone ? `(${row})` : row)).join(' '), isOutdated };
};

it('shows rows in the requested order while neither pointer nor focus is in the table', () => {
  const order = new RowOrder<string>();
  expect(shown(order, ['a1', 'b1'], false)).toEqual({ rows: 'a1 b1', isOutdated: false });
  expect(shown(order, ['b2', 'a2'], false)).toEqual({ rows: 'b2 a2', isOutdated: false });
});

it('moves no row while the order is held, and reports that the order is outdated', () => {
  const order = new RowOrder<string>();
  shown(order, ['a1', 'b1'], false);
  expect(shown(order, ['b2', 'a2'], true)).toEqual({ rows: 'a2 b2', isOutdated: true });
  expect(shown(order, ['a3', 'b3'], true)).toEqual({ rows: 'a3 b3', isOutdated: false });
});

it('keeps the place of a removed row, and puts new rows last', () => {
  const order = new RowOrder<string>();
  shown(order, ['a1', 'b1', 'c1'], false);
  expect(shown(order, ['n2', 'a2', 'c2'], true)).toEqual({ rows: 'a2 (b1) c2 n2', isOutdated: true });
  expect(shown(order, ['n3', 'a3', 'b3', 'c3'], true).rows).toBe('a3 b3 c3 n3');
  expect(shown(order, ['n4', 'a4', 'c4'], false)).toEqual({ rows: 'n4 a4 c4', isOutdated: false });
});

it('drops the oldest removed rows if there are more than MAX_GONE', () => {
  const order = new RowOrder<number>();
  const place = (rows: readonly number[]) => order.place(rows, String, true).placed;
  for (let i = 0; i < 5 * MAX_GONE; ++i) place([-1, i]);
  expect(place([-1, -2]).map(({ row }) => row)).toEqual([-1, ...Array.from({ length: MAX_GONE }, (_, i) => 4 * MAX_GONE + i), -2]);
});

it('uses the requested order if nothing was shown yet', () => {
  expect(shown(new RowOrder<string>(), ['b1', 'a1'], true)).toEqual({ rows: 'b1 a1', isOutdated: false });
});

it('sorts numbers by value, names by the numbers in them, and rows without a value last in both directions', () => {
  const rows = [{ v: 10 }, { v: undefined }, { v: 9 }, { v: NaN }];
  expect(sortedBy(rows, ({ v }) => v, false).map(({ v }) => v)).toEqual([9, 10, undefined, NaN]);
  expect(sortedBy(rows, ({ v }) => v, true).map(({ v }) => v)).toEqual([10, 9, undefined, NaN]);
  expect(sortedBy(['s10', 's9'], (row) => row, false)).toEqual(['s9', 's10']);
});
