// The order of a table's rows. While the user is in the table, updates may change a row but do not move it.
export interface PlacedRow<Row> {
  key: string;
  row: Row;
  isGone: boolean;  // the row was removed; it keeps its place while the order is held
}

// Maximum number of removed rows that are still shown, because a page may stay open with the pointer on a table.
export const MAX_GONE = 100;

function withoutOldestGone<Row>(placed: readonly PlacedRow<Row>[]): readonly PlacedRow<Row>[] {
  let over = placed.filter(({ isGone }) => isGone).length - MAX_GONE;
  return over <= 0 ? placed : placed.filter(({ isGone }) => !(isGone && over-- > 0));
}

export class RowOrder<Row> {
  private shown: readonly PlacedRow<Row>[] = [];

  // Returns the rows in the order to show, and whether it differs from that of `rows`. If `isHeld`, rows keep their places, new rows come last.
  place(rows: readonly Row[], keyOf: (row: Row) => string, isHeld: boolean): { placed: readonly PlacedRow<Row>[]; isOutdated: boolean } {
    const wanted = rows.map((row) => ({ key: keyOf(row), row, isGone: false }));
    if (!isHeld || this.shown.length === 0) {
      this.shown = wanted;
      return { placed: wanted, isOutdated: false };
    }
    const there = new Map(wanted.map((each) => [each.key, each]));
    const before = new Set(this.shown.map(({ key }) => key));
    this.shown = withoutOldestGone([
      ...this.shown.map((each) => there.get(each.key) ?? { ...each, isGone: true }),
      ...wanted.filter(({ key }) => !before.has(key)),
    ]);
    const isOutdated = this.shown.length !== wanted.length || this.shown.some(({ key }, i) => key !== wanted[i]!.key);
    return { placed: this.shown, isOutdated };
  }
}

export type SortValue = number | string | undefined;

const texts = new Intl.Collator('en', { numeric: true });

// Rows without a value come last in both directions. Equal rows keep their order.
export function sortedBy<Row>(rows: readonly Row[], valueOf: (row: Row) => SortValue, isDescending: boolean): Row[] {
  const sign = isDescending ? -1 : 1;
  const isNone = (value: SortValue) => value === undefined || Number.isNaN(value);
  return rows.map((row) => ({ row, value: valueOf(row) })).sort(({ value: a }, { value: b }) => {
    if (isNone(a) || isNone(b)) return Number(isNone(a)) - Number(isNone(b));
    if (typeof a === 'number' && typeof b === 'number') return sign * (a - b);
    return sign * texts.compare(String(a), String(b));
  }).map(({ row }) => row);
}
