// One colour and one symbol per algorithm, the same in every chart of every report. The colours
// can be told apart with any colour vision; colours.css holds them for both themes.
export const FAMILIES = ['BruteForce', 'Grid', 'SAP', 'AxisSweep', 'DBVT', 'Tracy', 'KDTree'];
const SYMBOLS = ['circle', 'square', 'triangle', 'diamond', 'hexagon', 'star', 'cross'] as const;
const TITLES: Record<string, string> = {
  BruteForce: 'Brute force', SAP: 'Sweep and prune (SAP)', AxisSweep: 'Incremental sweep (AxisSweep)',
  DBVT: 'Dynamic tree (DBVT)', KDTree: 'KD-tree',
};

// Algorithms that this page does not know come last.
export function familyRank(family: string): number {
  const index = FAMILIES.indexOf(family);
  return index < 0 ? FAMILIES.length : index;
}
export const familyTitle = (family: string) => TITLES[family] ?? family;
export const colourOf = (family: string) => `var(--arm-${familyRank(family)})`;
export const symbolOf = (family: string) => SYMBOLS[familyRank(family)] ?? 'wye';

// Text on an area: dark on sky and orange, where the theme's own would be hard to read.
export const textColourOn = (colour: string) => (/arm-[12]\b|kind-[23]\b/.test(colour) ? '#10141a' : 'var(--on-area)');

// For what is no algorithm: verdicts, parts of a frame.
export const kindColour = (index: number) => `var(--kind-${index % 9})`;
