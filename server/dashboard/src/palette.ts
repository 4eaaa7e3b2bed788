// One colour and one symbol per algorithm, the same in every chart of the dashboard and the report.
// The colours differ for every kind of colour vision; colours.css has them for both themes.
export const FAMILIES = ['BruteForce', 'Grid', 'SAP', 'AxisSweep', 'DBVT', 'Tracy', 'KDTree'];
const SYMBOLS = ['circle', 'square', 'triangle', 'diamond', 'hexagon', 'star', 'cross'] as const;
const TITLES: Record<string, string> = {
  BruteForce: 'Brute force', SAP: 'Sweep and prune (SAP)', AxisSweep: 'Incremental sweep (AxisSweep)',
  DBVT: 'Dynamic tree (DBVT)', KDTree: 'KD-tree',
};

// Algorithms that are not in FAMILIES come last.
export function familyRank(family: string): number {
  const index = FAMILIES.indexOf(family);
  return index < 0 ? FAMILIES.length : index;
}
export const familyTitle = (family: string) => TITLES[family] ?? family;
export const colourOf = (family: string) => `var(--arm-${familyRank(family)})`;
export const symbolOf = (family: string) => SYMBOLS[familyRank(family)] ?? 'wye';

// Colour of text on an area: dark on sky and orange, where the theme's text colour has too little contrast.
export const textColourOn = (colour: string) => (/arm-[12]\b|kind-[23]\b/.test(colour) ? '#10141a' : 'var(--on-area)');

// Colours for everything except algorithms: verdicts, parts of a frame.
export const kindColour = (index: number) => `var(--kind-${index % 9})`;
