// Decodes the boxes that a game sends (BoxView), and projects them onto the screen of an orbiting camera.
import type { BoxView } from '../../gen/sweepstake/v1/telemetry_pb';
import { resolved } from '../charts/colours';
import { rounded } from './ticks';

const BOX_BYTES = 12;
const PAIR_BYTES = 4;
const STEPS = 65_535; // coordinates are 16-bit fractions of the bounds

export interface Boxes {
  /** For each box the smallest x, y and z, then the largest, in world units. */
  readonly corners: Float32Array;
  readonly count: number;
  /** The indices of the two boxes of each pair. */
  readonly pairs: readonly (readonly [number, number])[];
  readonly objectCount: number;
  /** Every `stride`-th object is shown. */
  readonly stride: number;
  readonly frameIndex: bigint;
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

/** Decodes a message. Returns no boxes if it breaks the rules of BoxView. */
export function boxesOf(view: BoxView): Boxes {
  const { bounds, objectCount, stride, frameIndex } = view;
  const isWhole = bounds.length === 6 && bounds.every(Number.isFinite) && view.boxes.length % BOX_BYTES === 0;
  const count = isWhole ? view.boxes.length / BOX_BYTES : 0;
  const low: [number, number, number] = isWhole ? [bounds[0]!, bounds[1]!, bounds[2]!] : [0, 0, 0];
  const high: [number, number, number] = isWhole ? [bounds[3]!, bounds[4]!, bounds[5]!] : [0, 0, 0];
  const numbers = new DataView(view.boxes.buffer, view.boxes.byteOffset, view.boxes.byteLength);
  const corners = Float32Array.from({ length: 6 * count }, (_, i) => {
    const axis = i % 3;
    return low[axis]! + (numbers.getUint16(2 * i, true) / STEPS) * (high[axis]! - low[axis]!);
  });
  const places = new DataView(view.pairs.buffer, view.pairs.byteOffset, view.pairs.byteLength);
  const pairCount = isWhole ? Math.floor(view.pairs.length / PAIR_BYTES) : 0;
  const pairs = Array.from({ length: pairCount }, (_, i) => [places.getUint16(PAIR_BYTES * i, true), places.getUint16(PAIR_BYTES * i + 2, true)] as const)
    .filter((pair) => pair.every((place) => place < count));
  return { corners, count, pairs, objectCount, stride, frameIndex, low, high };
}

/** A camera that looks at the centre of the boxes. Angles are in radians; a zoom of 1 shows all boxes. The picture is moved by a share of
 * its smaller side, to the right and down. */
export interface Camera { readonly yaw: number; readonly pitch: number; readonly zoom: number; readonly right: number; readonly down: number }

export const START: Camera = { yaw: 0.7, pitch: 0.5, zoom: 1, right: 0, down: 0 };
const MAX_PITCH = Math.PI / 2 - 0.01;
const MIN_ZOOM = 0.2;
const MAX_ZOOM = 50;

const limited = (value: number, low: number, high: number) => Math.min(Math.max(value, low), high);

export const turned = (camera: Camera, right: number, up: number): Camera =>
  ({ ...camera, yaw: (camera.yaw + right) % (2 * Math.PI), pitch: limited(camera.pitch + up, -MAX_PITCH, MAX_PITCH) });
export const moved = (camera: Camera, right: number, down: number): Camera => ({ ...camera, right: camera.right + right, down: camera.down + down });
export const zoomed = (camera: Camera, factor: number): Camera => ({ ...camera, zoom: limited(camera.zoom * factor, MIN_ZOOM, MAX_ZOOM) });

/** Returns a function that writes the pixel of a point in world coordinates (y is up) into `out`. */
export function projection({ yaw, pitch, zoom, right, down }: Camera, low: readonly number[], high: readonly number[], width: number, height: number) {
  const middle = low.map((value, axis) => (value + high[axis]!) / 2);
  const radius = Math.hypot(...low.map((value, axis) => high[axis]! - value)) / 2 || 1;
  const side = Math.min(width, height);
  const scale = (zoom * side) / 2 / radius;
  const [sinYaw, cosYaw, sinPitch, cosPitch] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
  return (x: number, y: number, z: number, out: { x: number; y: number }): void => {
    const [dx, dy, dz] = [x - middle[0]!, y - middle[1]!, z - middle[2]!];
    const depth = sinYaw * dx + cosYaw * dz;
    out.x = width / 2 + right * side + scale * (cosYaw * dx - sinYaw * dz);
    out.y = height / 2 + down * side - scale * (cosPitch * dy - sinPitch * depth);
  };
}

// A corner is numbered by three bits (x, y, z); the two ends of an edge differ in one bit.
const EDGES = Array.from({ length: 8 }, (_, from) => [1, 2, 4].filter((bit) => (from & bit) === 0).map((bit) => [from, from | bit] as const)).flat();

interface Size { readonly width: number; readonly height: number } // in CSS pixels

/** Returns the boxes that overlap another box of this view. */
export const overlapsOf = ({ pairs }: Pick<Boxes, 'pairs'>): ReadonlySet<number> => new Set(pairs.flat());

function framesOf(boxes: Boxes, camera: Camera, { width, height }: Size): { plain: Path2D; overlapping: Path2D; pairs: Path2D } {
  const project = projection(camera, boxes.low, boxes.high, width, height);
  const overlaps = overlapsOf(boxes);
  const paths = { plain: new Path2D(), overlapping: new Path2D(), pairs: new Path2D() };
  const pixels = Array.from({ length: 8 }, () => ({ x: 0, y: 0 }));
  for (let box = 0; box < boxes.count; ++box) {
    const at = (corner: number, axis: number) => boxes.corners[6 * box + axis + ((corner >> axis) & 1 ? 3 : 0)]!;
    pixels.forEach((pixel, corner) => project(at(corner, 0), at(corner, 1), at(corner, 2), pixel));
    const path = overlaps.has(box) ? paths.overlapping : paths.plain;
    for (const [from, to] of EDGES) {
      path.moveTo(pixels[from]!.x, pixels[from]!.y);
      path.lineTo(pixels[to]!.x, pixels[to]!.y);
    }
  }
  for (const pair of boxes.pairs) {
    pair.forEach((box, i) => {
      const middle = (axis: number) => (boxes.corners[6 * box + axis]! + boxes.corners[6 * box + axis + 3]!) / 2;
      project(middle(0), middle(1), middle(2), pixels[i]!);
    });
    paths.pairs.moveTo(pixels[0]!.x, pixels[0]!.y);
    paths.pairs.lineTo(pixels[1]!.x, pixels[1]!.y);
  }
  return paths;
}

const MAX_LINES = 20; // of the ground, in one direction

/** Returns the distance of the ground's lines: 1, 2 or 5 times a power of ten world units, so that the longer side has 5 to 12 cells. */
export const cellOf = ({ low, high }: Pick<Boxes, 'low' | 'high'>) => rounded((Math.max(high[0] - low[0], high[2] - low[2]) || 1) / 12, true);

/** Returns the multiples of `cell` from `low` to `high`. Their number is bounded even if the coordinates are too large to tell them apart. */
export function linesOf(low: number, high: number, cell: number): number[] {
  const first = Math.ceil(low / cell);
  const count = Math.min(Math.max(Math.floor(high / cell) - first + 1, 0), MAX_LINES);
  return Array.from({ length: count }, (_, i) => (first + i) * cell);
}

type Point = readonly [number, number, number];

// Draws the ground, a grid at the lowest height of the boxes, and the three axes at their lowest corner.
function drawGround(pen: CanvasRenderingContext2D, { low, high }: Boxes, project: ReturnType<typeof projection>): void {
  const cell = cellOf({ low, high });
  const [a, b] = [{ x: 0, y: 0 }, { x: 0, y: 0 }];
  const line = (path: Path2D, from: Point, to: Point) => {
    project(...from, a);
    project(...to, b);
    path.moveTo(a.x, a.y);
    path.lineTo(b.x, b.y);
  };
  const grid = new Path2D();
  for (const x of linesOf(low[0], high[0], cell)) line(grid, [x, low[1], low[2]], [x, low[1], high[2]]);
  for (const z of linesOf(low[2], high[2], cell)) line(grid, [low[0], low[1], z], [high[0], low[1], z]);
  Object.assign(pen, { strokeStyle: resolved('var(--rule)'), lineWidth: 1 });
  pen.stroke(grid);
  for (const [axis, name] of ['x', 'y', 'z'].entries()) {
    const path = new Path2D();
    const end: Point = [low[0] + (axis === 0 ? cell : 0), low[1] + (axis === 1 ? cell : 0), low[2] + (axis === 2 ? cell : 0)];
    line(path, low, end);
    Object.assign(pen, { strokeStyle: resolved('var(--text)'), fillStyle: resolved('var(--text)'), lineWidth: 1.5, font: '12px system-ui, sans-serif' });
    pen.stroke(path);
    pen.fillText(name, b.x + 3, b.y - 3);
  }
}

export function drawBoxes(canvas: HTMLCanvasElement, boxes: Boxes, camera: Camera, size: Size): void {
  const scale = Math.min(devicePixelRatio || 1, 2);
  canvas.width = Math.round(size.width * scale);
  canvas.height = Math.round(size.height * scale);
  const pen = canvas.getContext('2d');
  if (!pen) return;
  pen.scale(scale, scale);
  const { plain, overlapping, pairs } = framesOf(boxes, camera, size);
  drawGround(pen, boxes, projection(camera, boxes.low, boxes.high, size.width, size.height));
  const opacity = boxes.count > 1000 ? 0.35 : 0.7;
  for (const [path, colour, alpha, lineWidth] of [[plain, 'soft', opacity, 0.75], [overlapping, 'bad', opacity, 0.75], [pairs, 'accent', 1, 1.5]] as const) {
    Object.assign(pen, { strokeStyle: resolved(`var(--${colour})`), globalAlpha: alpha, lineWidth });
    pen.stroke(path);
  }
}
