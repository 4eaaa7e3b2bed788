// A dash for lines and a hatch for areas, so that arms differ without colour. Built-in arms have the same style in every chart;
// custom arms take the remaining styles in their order.
import { colourOf, FAMILIES, familyRank } from '../../palette';

const DASHES: readonly (readonly number[])[] = [
  [2, 3], [8, 3], [], [10, 3, 2, 3], [5, 2], [12, 2, 2, 2, 2, 2], [16, 3, 4, 3],
];
const UNKNOWN_DASHES: readonly (readonly number[])[] = [[4, 4], [14, 4], [2, 6], [8, 2, 1, 2], [3, 1, 1, 1], [6, 6]];

// Custom arms share one colour. Arms beyond the list repeat its dashes, each time with one more dot at the end.
const unknownDash = (place: number) =>
  [...UNKNOWN_DASHES[place % UNKNOWN_DASHES.length]!, ...Array.from({ length: Math.floor(place / UNKNOWN_DASHES.length) }, () => [1, 3]).flat()];

export interface ArmStyle { colour: string; dash: number[]; hatch: number }

/** REQUIRES: `arm` is one of `arms`. */
export function armStyle(arm: string, arms: readonly string[]): ArmStyle {
  const rank = familyRank(arm);
  if (rank < FAMILIES.length) return { colour: colourOf(arm), dash: [...DASHES[rank]!], hatch: rank };
  const place = Math.max(arms.filter((other) => familyRank(other) === FAMILIES.length).indexOf(arm), 0);
  return { colour: colourOf(arm), dash: unknownDash(place), hatch: FAMILIES.length + place };
}
