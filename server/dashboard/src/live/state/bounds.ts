// Bounds of the page's memory. The page may be open for weeks, with any number of scenes and sessions.
export const MAX_DECISIONS = 20_000;
const MIN_SHARE = 20;

// Returns how many decisions each of `count` scenes or sessions may keep (at most `most`), so that all together keep about MAX_DECISIONS.
export const shareOf = (count: number, most: number) =>
  Math.max(MIN_SHARE, Math.min(most, Math.floor(MAX_DECISIONS / Math.max(count, 1))));

export function keepLast<Item>(before: readonly Item[], added: readonly Item[], limit: number): readonly Item[] {
  return [...before, ...added].slice(-limit);
}
