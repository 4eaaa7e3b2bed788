// The page is left open for weeks; what it remembers is bounded, however many scenes and sessions there are.
export const MAX_DECISIONS = 20_000;
const MIN_SHARE = 20;

// How many decisions each of `count` holders may keep, so that all of them together keep about MAX_DECISIONS.
export const shareOf = (count: number, most: number) =>
  Math.max(MIN_SHARE, Math.min(most, Math.floor(MAX_DECISIONS / Math.max(count, 1))));

export function keepLast<Item>(before: readonly Item[], added: readonly Item[], limit: number): readonly Item[] {
  return [...before, ...added].slice(-limit);
}
