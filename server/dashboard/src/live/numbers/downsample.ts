// Reduces the points of a chart. Divides x into ranges of equal length and keeps the points where a column is lowest or highest, so
// that no spike is lost. Pure functions.

/** The values of a column; null, undefined and NaN are missing values. */
export type Column = ArrayLike<number | null | undefined>;

function extremesWithin(columns: readonly Column[], from: number, to: number, keep: Set<number>): void {
  for (const column of columns) {
    let low = -1;
    let high = -1;
    for (let i = from; i < to; ++i) {
      const value = column[i];
      if (value === null || value === undefined || Number.isNaN(value)) continue;
      if (low < 0 || value < column[low]!) low = i;
      if (high < 0 || value > column[high]!) high = i;
    }
    if (low >= 0) keep.add(low).add(high);
  }
}

/** Returns the indices of at most `limit` points, ascending: the first and the last index, and in each range of x the indices at which a
 * column is lowest or highest. If `limit` is below 2 + 2 × columns, up to 2 + 2 × columns points are kept. REQUIRES: x ascends. */
export function keepExtremes(x: ArrayLike<number>, columns: readonly Column[], limit: number): number[] {
  const length = x.length;
  if (length <= limit) return Array.from({ length }, (_, i) => i);
  const rangeCount = Math.max(1, Math.floor((limit - 2) / (2 * Math.max(columns.length, 1))));
  const first = x[0]!;
  const width = (x[length - 1]! - first) / rangeCount;
  const keep = new Set([0, length - 1]);
  let from = 0;
  for (let range = 1; range <= rangeCount; ++range) {
    let to = from;
    while (to < length && (range === rangeCount || x[to]! < first + range * width)) ++to;
    extremesWithin(columns, from, to, keep);
    from = to;
  }
  return [...keep].sort((a, b) => a - b);
}
