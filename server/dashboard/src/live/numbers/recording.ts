// Reads recordings of boxes: .aabbs files, which engine_client/scene/README.md describes. The memory is that of one frame.
import { grouped } from '../../format';
import type { Boxes } from './boxes';

const HEADER_BYTES = 304;
const BOX_BYTES = 32;
const COUNT_BYTES = 4;
const MAX_NOTES_BYTES = 16 * 2 ** 20;
const MAX_OBJECTS = 1_000_000; // of a frame, and
const MAX_FRAMES = 10_000_000; // of a recording: up to 40 MB of memory
const MAX_SHOWN = 5_000; // boxes; of more objects, only every so many is shown
const MAX_PAIRS = 20_000;

export interface Recording {
  readonly name: string; // of the scene
  readonly frameCount: number;
  /** Returns the boxes of a frame, counted from 0. Throws an Error if it cannot be read. */
  read(frame: number): Promise<Boxes>;
}

const view = async (file: Blob, from: number, bytes: number) => new DataView(await file.slice(from, from + bytes).arrayBuffer());
const corner = (box: DataView, at: number) => [0, 4, 8].map((offset) => box.getFloat32(at + offset, true)) as [number, number, number];

function check(isRight: boolean, problem: string): void {
  if (!isRight) throw new Error(problem);
}

/** Returns the pairs of boxes that overlap, at most MAX_PAIRS: a sweep along x. */
export function pairsOf(corners: Float32Array): [number, number][] {
  const at = (box: number, place: number) => corners[6 * box + place]!;
  const isValid = (box: number) => [0, 1, 2].every((axis) => at(box, axis) <= at(box, axis + 3));
  const reach = (a: number, b: number, axis: number) => at(a, axis) <= at(b, axis + 3) && at(b, axis) <= at(a, axis + 3);
  const order = Array.from({ length: corners.length / 6 }, (_, box) => box).filter(isValid).sort((a, b) => at(a, 0) - at(b, 0));
  const pairs: [number, number][] = [];
  for (const [place, a] of order.entries()) {
    for (let next = place + 1; next < order.length && at(order[next]!, 0) <= at(a, 3); ++next) {
      const b = order[next]!;
      if (reach(a, b, 1) && reach(a, b, 2) && pairs.push([a, b]) === MAX_PAIRS) return pairs;
    }
  }
  return pairs;
}

function boxesOf(bytes: DataView, frame: number, low: Boxes['low'], high: Boxes['high']): Boxes {
  const objectCount = bytes.byteLength / BOX_BYTES;
  const stride = Math.max(Math.ceil(objectCount / MAX_SHOWN), 1);
  const count = Math.ceil(objectCount / stride);
  const corners = new Float32Array(6 * count);
  for (let box = 0; box < count; ++box) {
    const at = box * stride * BOX_BYTES;
    corners.set([...corner(bytes, at), ...corner(bytes, at + BOX_BYTES / 2)], 6 * box);
  }
  check(corners.every(Number.isFinite), `frame ${frame} has a coordinate that is not finite`);
  return { corners, count, pairs: pairsOf(corners), objectCount, stride, frameIndex: BigInt(frame), low, high };
}

// Returns the number of boxes before each frame, and after the last one.
async function placesOf(file: Blob, header: DataView, frameCount: number, notesBytes: number): Promise<Float64Array> {
  const [largest, layout] = [header.getInt32(256, true), header.getInt32(264, true)];
  const tableBytes = layout === 1 ? COUNT_BYTES * frameCount : 0;
  const tableAt = file.size - notesBytes - tableBytes;
  check(tableAt >= HEADER_BYTES, 'the file is too short');
  const table = await view(file, tableAt, tableBytes);
  const places = new Float64Array(frameCount + 1);
  for (let frame = 0; frame < frameCount; ++frame) {
    const count = layout === 1 ? table.getInt32(COUNT_BYTES * frame, true) : largest;
    check(count >= 0 && count <= largest, `frame ${frame} has ${count} objects, but the header allows 0 to ${largest}`);
    places[frame + 1] = places[frame]! + count;
  }
  check(tableAt === HEADER_BYTES + BOX_BYTES * places[frameCount]!, 'the size of the file does not match its header');
  return places;
}

/** Opens a recording. Throws an Error that says why the file is none. */
export async function openRecording(file: Blob): Promise<Recording> {
  check(file.size >= HEADER_BYTES, 'the file is shorter than the header of a recording');
  const header = await view(file, 0, HEADER_BYTES);
  const text = new TextDecoder('latin1').decode(header.buffer.slice(0, 128));
  const [name] = text.split('\0');
  check(text.includes('\0') && /^[\x20-\x7e]*$/.test(name!), 'the file does not begin with the name of a scene');
  const [objectCount, steps, layout, notesBytes] = [256, 260, 264, 268].map((at) => header.getInt32(at, true)) as [number, number, number, number];
  check(objectCount >= 1 && objectCount <= MAX_OBJECTS, `the object count is ${objectCount}, but must be 1 to ${grouped(MAX_OBJECTS)}`);
  check(steps >= 0 && steps < MAX_FRAMES, `the frame count is ${steps}, but must be 0 to ${grouped(MAX_FRAMES - 1)}`);
  check(layout === 0 || layout === 1, `the layout is ${layout}, but must be 0 or 1`);
  check(notesBytes >= 0 && notesBytes <= MAX_NOTES_BYTES, `the notes have ${notesBytes} bytes, but must have 0 to ${MAX_NOTES_BYTES}`);
  const [low, high] = [corner(header, 272), corner(header, 288)];
  check(low.every((value, axis) => value <= high[axis]! && Number.isFinite(high[axis]! - value)), 'the bounds of the world are not finite, or inverted');
  const places = await placesOf(file, header, steps + 1, notesBytes);
  const read = async (frame: number) =>
    boxesOf(await view(file, HEADER_BYTES + BOX_BYTES * places[frame]!, BOX_BYTES * (places[frame + 1]! - places[frame]!)), frame, low, high);
  return { name: name!, frameCount: steps + 1, read };
}
