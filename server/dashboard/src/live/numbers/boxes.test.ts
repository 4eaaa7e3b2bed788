import { create } from '../transport/messages';
import { expect, it } from 'vitest';
import { BoxViewSchema } from '../../gen/sweepstake/v1/telemetry_pb';
import { boxesOf, cellOf, linesOf, moved, overlapsOf, projection, START, turned, zoomed } from './boxes';

const littleEndian = (...numbers: number[]) => new Uint8Array(new Uint16Array(numbers).buffer);
const VIEW = { frameIndex: 7n, objectCount: 9, stride: 3, bounds: [-1, 0, 2, 1, 10, 4],
  boxes: littleEndian(0, 0, 0, 65535, 65535, 65535, 32768, 0, 65535, 65535, 6554, 65535, 0, 0, 0, 1, 1, 1), pairs: littleEndian(0, 2) };

it('boxes are decoded within the bounds, and boxes of a pair are marked as overlapping', () => {
  const boxes = boxesOf(create(BoxViewSchema, VIEW));
  expect(boxes).toMatchObject({ count: 3, objectCount: 9, stride: 3, frameIndex: 7n });
  expect(Array.from(boxes.corners.subarray(0, 6))).toEqual([-1, 0, 2, 1, 10, 4]);
  expect(boxes.corners[6]).toBeCloseTo(0, 4);
  expect(boxes.corners[10]).toBeCloseTo(1, 3);
  expect([...overlapsOf(boxes)]).toEqual([0, 2]);
  expect(boxes.pairs).toEqual([[0, 2]]);
});

it('a message that breaks the rules has no boxes', () => {
  expect(boxesOf(create(BoxViewSchema, { ...VIEW, bounds: [0, 0, 0] })).count).toBe(0);
  expect(boxesOf(create(BoxViewSchema, { ...VIEW, bounds: [0, 0, 0, Number.NaN, 1, 1] })).count).toBe(0);
  expect(boxesOf(create(BoxViewSchema, { ...VIEW, boxes: littleEndian(1, 2, 3) })).count).toBe(0);
  expect(boxesOf(create(BoxViewSchema, { ...VIEW, pairs: littleEndian(2, 900) }))).toMatchObject({ pairs: [] });
  expect(boxesOf(create(BoxViewSchema, {})).count).toBe(0);
});

it('the centre is projected to the centre from every angle, and all boxes are visible at a zoom of 1', () => {
  const [low, high] = [[-1, 0, 2], [1, 10, 4]] as const;
  for (let i = 0; i < 20; ++i) {
    const project = projection(turned(START, 0.7 * i, 0.3 * i - 3), low, high, 400, 300);
    const at = { x: 0, y: 0 };
    project(0, 5, 3, at);
    expect(at.x).toBeCloseTo(200, 9);
    expect(at.y).toBeCloseTo(150, 9);
    for (let corner = 0; corner < 8; ++corner) {
      project(corner & 1 ? 1 : -1, corner & 2 ? 10 : 0, corner & 4 ? 4 : 2, at);
      expect(Math.hypot(at.x - 200, at.y - 150)).toBeLessThanOrEqual(150 + 1e-9);
    }
  }
});

it('y points up from the side, and pitch and zoom have limits', () => {
  const at = { x: 0, y: 0 };
  projection({ ...START, yaw: 0, pitch: 0 }, [0, 0, 0], [2, 2, 2], 200, 200)(1, 2, 1, at);
  expect(at.x).toBeCloseTo(100, 9);
  expect(at.y).toBeLessThan(100);
  expect(turned(START, 0, 100).pitch).toBeLessThan(Math.PI / 2);
  expect(zoomed(START, 1e9).zoom).toBe(zoomed(zoomed(START, 1e9), 2).zoom);
});

it('the picture can be moved by a share of its smaller side', () => {
  const at = { x: 0, y: 0 };
  projection(moved(START, 0.25, -0.5), [0, 0, 0], [2, 2, 2], 400, 200)(1, 1, 1, at);
  expect(at.x).toBeCloseTo(200 + 50, 9);
  expect(at.y).toBeCloseTo(100 - 100, 9);
});

it('the ground has 5 to 12 round cells along its longer side', () => {
  for (const length of [0.07, 1, 1.3, 2.4, 6, 9.9, 10, 123, 5e6]) {
    const cell = cellOf({ low: [0, 0, -length / 2], high: [length / 3, 9, length / 2] });
    expect(length / cell).toBeGreaterThanOrEqual(4.9);
    expect(length / cell).toBeLessThanOrEqual(12.1);
    expect(Number((cell / 10 ** Math.floor(Math.log10(cell) + 1e-9)).toPrecision(6))).toSatisfy((step: number) => [1, 2, 5].includes(step));
  }
  expect(cellOf({ low: [1, 1, 1], high: [1, 1, 1] })).toBeGreaterThan(0);
});

it('the lines of the ground are multiples of a cell, and few even far from the origin', () => {
  expect(linesOf(-1.2, 2.1, 0.5)).toEqual([-1, -0.5, 0, 0.5, 1, 1.5, 2]);
  expect(linesOf(0.1, 0.2, 0.5)).toEqual([]);
  expect(linesOf(1e17, 1e17, 0.1).length).toBeLessThanOrEqual(20);
  expect(linesOf(-1e300, 1e300, 1).length).toBeLessThanOrEqual(20);
});
