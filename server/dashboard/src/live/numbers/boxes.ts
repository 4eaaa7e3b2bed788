// Decodes the boxes that a game sends (BoxView), and projects them onto the screen of an orbiting camera.
import type { BoxView } from '../../gen/sweepstake/v1/telemetry_pb';

const BOX_BYTES = 12;
const PAIR_BYTES = 4;
const STEPS = 65_535; // coordinates are 16-bit fractions of the bounds

export interface Boxes {
  /** For each box the smallest x, y and z, then the largest, in world units. */
  readonly corners: Float32Array;
  readonly count: number;
  readonly pairCount: number;
  /** The indices of the two boxes of each pair. */
  readonly pairs: readonly (readonly [number, number])[];
  /** Per box 1 if it overlaps another box of this view, else 0. */
  readonly overlaps: Uint8Array;
  readonly objectCount: number;
  /** Every `stride`-th object is shown. */
  readonly stride: number;
  readonly frameIndex: bigint;
  readonly low: readonly [number, number, number];
  readonly high: readonly [number, number, number];
}

/** Returns no boxes if the message breaks the rules of BoxView. */
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
  const overlaps = new Uint8Array(count);
  for (const place of pairs.flat()) overlaps[place] = 1;
  return { corners, count, pairCount: pairs.length, pairs, overlaps, objectCount, stride, frameIndex, low, high };
}

/** A camera that looks at the centre of the boxes. Angles are in radians; a zoom of 1 shows all boxes. */
export interface Camera { readonly yaw: number; readonly pitch: number; readonly zoom: number }

export const START: Camera = { yaw: 0.7, pitch: 0.5, zoom: 1 };
const MAX_PITCH = Math.PI / 2 - 0.01;
const MIN_ZOOM = 0.2;
const MAX_ZOOM = 50;

const limited = (value: number, low: number, high: number) => Math.min(Math.max(value, low), high);

export const turned = ({ yaw, pitch, zoom }: Camera, right: number, up: number): Camera =>
  ({ yaw: (yaw + right) % (2 * Math.PI), pitch: limited(pitch + up, -MAX_PITCH, MAX_PITCH), zoom });
export const zoomed = (camera: Camera, factor: number): Camera => ({ ...camera, zoom: limited(camera.zoom * factor, MIN_ZOOM, MAX_ZOOM) });

/** Returns a function that writes the pixel of a point in world coordinates (y is up) into `out`. */
export function projection({ yaw, pitch, zoom }: Camera, low: readonly number[], high: readonly number[], width: number, height: number) {
  const middle = low.map((value, axis) => (value + high[axis]!) / 2);
  const radius = Math.hypot(...low.map((value, axis) => high[axis]! - value)) / 2 || 1;
  const scale = (zoom * Math.min(width, height)) / 2 / radius;
  const [sinYaw, cosYaw, sinPitch, cosPitch] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
  return (x: number, y: number, z: number, out: { x: number; y: number }): void => {
    const [dx, dy, dz] = [x - middle[0]!, y - middle[1]!, z - middle[2]!];
    const depth = sinYaw * dx + cosYaw * dz;
    out.x = width / 2 + scale * (cosYaw * dx - sinYaw * dz);
    out.y = height / 2 - scale * (cosPitch * dy - sinPitch * depth);
  };
}
