import { describe, expect, it } from 'vitest';
import { openRecording, pairsOf } from './recording';

type Box = readonly [number, number, number, number, number, number];
const WORLD: Box = [-10, -10, -10, 10, 10, 10];

interface Parts { frames: readonly (readonly Box[])[]; layout?: number; notes?: string; world?: Box; name?: string; largest?: number; steps?: number }

const boxBytes = (boxes: readonly Box[]) => Float32Array.from(boxes.flatMap(([a, b, c, d, e, f]) => [a, b, c, 0, d, e, f, 0]));

// Returns a file as engine_client/scene/README.md describes it.
function fileOf({ frames, layout = 0, notes = '', world = WORLD, name = 'arena\0', largest = Math.max(...frames.map((boxes) => boxes.length)), steps = frames.length - 1 }: Parts): Blob {
  const header = new DataView(new ArrayBuffer(304));
  [...name.padEnd(128, '\0'), ...'AABB\0'].forEach((sign, at) => header.setUint8(at, sign.charCodeAt(0)));
  [largest, steps, layout, notes.length].forEach((value, i) => header.setInt32(256 + 4 * i, value, true));
  new Uint8Array(header.buffer).set(new Uint8Array(boxBytes([world]).buffer), 272);
  const table = layout === 1 ? [Int32Array.from(frames.map((boxes) => boxes.length))] : [];
  return new Blob([header, ...frames.map(boxBytes), ...table, notes]);
}

const box = (x: number, y = 0): Box => [x, y, 0, x + 1, y + 1, 1];

describe('a recording', () => {
  it('has the boxes of each frame', async () => {
    const recording = await openRecording(fileOf({ frames: [[box(0), box(5)], [box(1), box(1.5)]], notes: '{"about": "it"}' }));
    expect(recording).toMatchObject({ name: 'arena', frameCount: 2 });
    const [first, second] = [await recording.read(0), await recording.read(1)];
    expect([...first.corners]).toEqual([0, 0, 0, 1, 1, 1, 5, 0, 0, 6, 1, 1]);
    expect(first).toMatchObject({ count: 2, objectCount: 2, stride: 1, pairs: [], frameIndex: 0n, low: [-10, -10, -10], high: [10, 10, 10] });
    expect(second.corners.slice(0, 6)).toEqual(Float32Array.of(1, 0, 0, 2, 1, 1));
    expect(second).toMatchObject({ pairs: [[0, 1]], frameIndex: 1n });
  });

  it('may have another number of objects in each frame', async () => {
    const recording = await openRecording(fileOf({ layout: 1, frames: [[box(0)], [], [box(1), box(2), box(3)]] }));
    expect(await Promise.all([0, 1, 2].map(async (frame) => (await recording.read(frame)).count))).toEqual([1, 0, 3]);
    expect((await recording.read(2)).corners[0]).toBe(1);
  });

  it('shows every so many of many objects', async () => {
    const many = Array.from({ length: 12_001 }, (_, i) => box(2 * i));
    const boxes = await (await openRecording(fileOf({ frames: [many] }))).read(0);
    expect(boxes).toMatchObject({ stride: 3, count: 4001, objectCount: 12_001 });
    expect(boxes.corners[6]).toBe(6);
  });

  it('is refused with the reason if it is broken', async () => {
    const frames = [[box(0)], [box(1)]];
    const problem = (file: Blob) => openRecording(file).then(() => 'none', (error: Error) => error.message);
    expect(await problem(new Blob(['{}']))).toMatch(/shorter than the header/);
    expect(await problem(new Blob(['x'.repeat(400)]))).toMatch(/name of a scene/);
    expect(await problem(fileOf({ frames, name: 'a\nb' }))).toMatch(/name of a scene/);
    expect(await problem(fileOf({ frames, largest: 0 }))).toMatch(/object count is 0/);
    expect(await problem(fileOf({ frames, largest: 2_000_000 }))).toMatch(/1 to 1,000,000/);
    expect(await problem(fileOf({ frames, steps: -1 }))).toMatch(/frame count is -1/);
    expect(await problem(fileOf({ frames, layout: 2 }))).toMatch(/layout is 2/);
    expect(await problem(fileOf({ frames, steps: 5 }))).toMatch(/does not match/);
    expect(await problem(fileOf({ frames, layout: 1, steps: 1000 }))).toMatch(/too short/);
    expect(await problem(fileOf({ frames, layout: 1, largest: 3, notes: 'x' }).slice(0, -2))).toMatch(/objects, but the header|does not match/);
    expect(await problem(fileOf({ frames, world: [0, 0, 0, 1, 1, Number.NaN] }))).toMatch(/bounds of the world/);
    expect(await problem(fileOf({ frames, world: [0, 0, 0, 1, 1, -1] }))).toMatch(/bounds of the world/);
    const recording = await openRecording(fileOf({ frames: [[box(0)], [box(Number.POSITIVE_INFINITY)]] }));
    await expect(recording.read(1)).rejects.toThrow('frame 1 has a coordinate that is not finite');
  });
});

it('pairs are those of a comparison of all boxes, and an inverted box has none', () => {
  const place = (i: number) => ((i * 7919) % 101) / 10;
  const boxes = Array.from({ length: 80 }, (_, i): Box => [place(i), place(3 * i + 1), place(5 * i + 2), place(i) + 2, place(3 * i + 1) + 2, place(5 * i + 2) + (i % 9 === 0 ? -1 : 2)]);
  const isValid = (each: Box) => [0, 1, 2].every((axis) => each[axis]! <= each[axis + 3]!);
  const expected = boxes.flatMap((a, i) => boxes.flatMap((b, j) =>
    (i < j && isValid(a) && isValid(b) && [0, 1, 2].every((axis) => a[axis]! <= b[axis + 3]! && b[axis]! <= a[axis + 3]!) ? [`${i} ${j}`] : [])));
  const found = pairsOf(Float32Array.from(boxes.flat())).map((pair) => [...pair].sort((a, b) => a - b).join(' '));
  expect([...found].sort()).toEqual([...expected].sort());
  expect(found.length).toBeGreaterThan(20);
});
