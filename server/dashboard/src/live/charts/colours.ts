// Colours for canvases, which cannot use CSS variables. A chart that reads `theme` is redrawn when the theme changes.
import { signal, type ReadonlySignal } from '@preact/signals';

const version = signal(0);
/** Changes its value whenever the colours change. */
export const theme: ReadonlySignal<number> = version;

const known = new Map<string, string>();
const tiles = new Map<string, HTMLCanvasElement>();
let probe: HTMLElement | undefined;

function forget(): void {
  known.clear();
  tiles.clear();
  version.value += 1;
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

// Eight hatches that differ without colour, as line segments in a square of 8 × 8 pixels.
const HATCHES: readonly (readonly [number, number, number, number])[][] = [
  [], [[0, 8, 8, 0]], [[0, 0, 8, 8]], [[0, 4, 8, 4]], [[4, 0, 4, 8]], [[0, 8, 8, 0], [0, 0, 8, 8]], [[0, 2, 8, 2], [0, 6, 8, 6]],
  [[2, 0, 2, 8], [6, 0, 6, 8]],
];

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
  pen.strokeStyle = resolved(colour);
  pen.lineWidth = 1.2;
  for (const [x1, y1, x2, y2] of HATCHES[hatch % HATCHES.length]!) {
    pen.beginPath();
    pen.moveTo(x1, y1);
    pen.lineTo(x2, y2);
    pen.stroke();
  }
  tiles.set(name, tile);
  return tile;
}

/** Returns a fill of this colour with hatch number `hatch`, for adjacent areas. */
export function hatched(context: CanvasRenderingContext2D, colour: string, hatch: number): CanvasPattern | string {
  const tile = tileOf(colour, hatch, Math.max(1, Math.round(devicePixelRatio)));
  return (tile && context.createPattern(tile, 'repeat')) ?? translucent(colour, 0.6);
}
