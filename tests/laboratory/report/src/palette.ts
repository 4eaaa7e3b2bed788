// Names of algorithms, and colours for what is not an algorithm.
const TITLES: Record<string, string> = {
  BruteForce: 'Brute force', SAP: 'Sweep and prune (SAP)', AxisSweep: 'Incremental sweep (AxisSweep)',
  DBVT: 'Dynamic tree (DBVT)', KDTree: 'KD-tree',
};

export const familyTitle = (family: string) => TITLES[family] ?? family;

// Colour of text on an area: dark on sky and orange, where the theme's text colour has too little contrast.
export const textColourOn = (colour: string) => (/arm-[12]\b|kind-[23]\b/.test(colour) ? '#10141a' : 'var(--on-area)');

// Colours for everything except algorithms: verdicts, parts of a frame.
export const kindColour = (index: number) => `var(--kind-${index % 9})`;
