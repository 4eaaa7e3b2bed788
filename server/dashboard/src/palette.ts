// One colour and one symbol per algorithm, the same in every chart of the dashboard and the report.
// The colours differ for every kind of colour vision; colours.css has them for both themes.
export const FAMILIES = ['BruteForce', 'Grid', 'SAP', 'AxisSweep', 'DBVT', 'Tracy', 'KDTree'];
const SYMBOLS = ['circle', 'square', 'triangle', 'diamond', 'hexagon', 'star', 'cross'] as const;

// Algorithms that are not in FAMILIES come last.
export function familyRank(family: string): number {
  const index = FAMILIES.indexOf(family);
  return index < 0 ? FAMILIES.length : index;
}
export const colourOf = (family: string) => `var(--arm-${familyRank(family)})`;
export const symbolOf = (family: string) => SYMBOLS[familyRank(family)] ?? 'wye';
