// Colours for canvases, which cannot use CSS variables. A chart that reads `theme` is redrawn when the theme changes.
import { signal } from '@preact/signals';
import { colourOf, FAMILIES, familyRank } from '../../palette';

/** A number that changes whenever the colours change. */
export const theme = signal(0);

const known = new Map<string, string>();
const tiles = new Map<string, HTMLCanvasElement>();
let probe: HTMLElement | undefined;

function forget(): void {
  known.clear();
  tiles.clear();
  theme.value += 1;
}

function begin(): HTMLElement {
  const element = document.createElement('span');
  element.hidden = true;
  document.body.append(element);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', forget);
  new MutationObserver(forget).observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
  return element;
}

/** Returns a colour such as var(--arm-3) as rgb(…), in the current theme. */
export function resolved(colour: string): string {
  const before = known.get(colour);
  if (before) return before;
  probe ??= begin();
  probe.style.color = '';
  probe.style.color = colour;
  const rgb = getComputedStyle(probe).color;
  known.set(colour, rgb);
  return rgb;
}

export const translucent = (colour: string, opacity: number) =>
  resolved(colour).replace(/^rgb\(([^)]*)\)$/, (_, channels: string) => `rgba(${channels.replaceAll(' ', ', ').replaceAll(',,', ',')}, ${opacity})`);

// Eight hatches that differ without colour, as paths in a square of 8 × 8 pixels.
const HATCHES = ['', 'M0 8L8 0', 'M0 0L8 8', 'M0 4H8', 'M4 0V8', 'M0 8L8 0M0 0L8 8', 'M0 2H8M0 6H8', 'M2 0V8M6 0V8'];

function tileOf(colour: string, hatch: number, scale: number): HTMLCanvasElement | undefined {
  const name = `${colour} ${hatch} ${scale}`;
  const before = tiles.get(name);
  if (before) return before;
  const tile = document.createElement('canvas');
  tile.width = tile.height = 8 * scale;
  const pen = tile.getContext('2d');
  if (!pen) return undefined;
  pen.scale(scale, scale);
  pen.fillStyle = translucent(colour, 0.55);
  pen.fillRect(0, 0, 8, 8);
  pen.strokeStyle = translucent(colour, 0.7);
  pen.lineWidth = 1;
  pen.stroke(new Path2D(HATCHES[hatch % HATCHES.length]));
  tiles.set(name, tile);
  return tile;
}

export function hatched(context: CanvasRenderingContext2D, colour: string, hatch: number): CanvasPattern | string {
  const tile = tileOf(colour, hatch, Math.max(1, Math.round(devicePixelRatio)));
  return (tile && context.createPattern(tile, 'repeat')) ?? translucent(colour, 0.6);
}

const DASHES: readonly (readonly number[])[] = [
  [2, 3], [8, 3], [], [10, 3, 2, 3], [5, 2], [12, 2, 2, 2, 2, 2], [16, 3, 4, 3],
];
const UNKNOWN_DASHES: readonly (readonly number[])[] = [[4, 4], [14, 4], [2, 6], [8, 2, 1, 2], [3, 1, 1, 1], [6, 6]];

// Returns the dash of a custom arm. Custom arms share one colour. Arms beyond the list repeat its dashes with more dots at the end.
const unknownDash = (place: number) =>
  [...UNKNOWN_DASHES[place % UNKNOWN_DASHES.length]!, ...Array.from({ length: Math.floor(place / UNKNOWN_DASHES.length) }, () => [1, 3]).flat()];

/** REQUIRES: `arm` is one of `arms`. */
export function armStyle(arm: string, arms: readonly string[]) {
  const rank = familyRank(arm);
  if (rank < FAMILIES.length) return { colour: colourOf(arm), dash: [...DASHES[rank]!], hatch: rank };
  const place = Math.max(arms.filter((other) => familyRank(other) === FAMILIES.length).indexOf(arm), 0);
  return { colour: colourOf(arm), dash: unknownDash(place), hatch: FAMILIES.length + place };
}
