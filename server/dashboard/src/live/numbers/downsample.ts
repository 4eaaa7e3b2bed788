// Reduces the points of a chart. Divides x into ranges of equal length and keeps the points where a column is lowest or highest, so
// that no spike is lost. Pure functions.

/** Returns the indices of at most `limit` points, ascending: the first and the last index, and in each range of x the indices at which a
 * column is lowest or highest. If `limit` is below 2 + 2 × columns, up to 2 + 2 × columns points are kept. REQUIRES: x ascends. */
export function keepExtremes(x: readonly number[], columns: readonly (readonly (number | null)[])[], limit: number): number[] {
  if (x.length <= limit) return [...x.keys()];
  const rangeCount = Math.max(1, Math.floor((limit - 2) / (2 * Math.max(columns.length, 1))));
  const width = (x.at(-1)! - x[0]!) / rangeCount || 1;
  const keep = new Set([0, x.length - 1]);
  for (const column of columns) {
    const [lowest, highest]: [number[], number[]] = [[], []]; // by range
    for (const [i, value] of column.entries()) {
      if (value === null) continue;
      const range = Math.min(Math.floor((x[i]! - x[0]!) / width), rangeCount - 1);
      if (!(value >= column[lowest[range] ?? -1]!)) lowest[range] = i;
      if (!(value <= column[highest[range] ?? -1]!)) highest[range] = i;
    }
    for (const places of [lowest, highest]) places.forEach((i) => keep.add(i));
  }
  return [...keep].sort((a, b) => a - b);
}
