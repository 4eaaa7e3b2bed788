// Draws boxes as wire frames. Overlapping boxes have another colour and are in front. A line connects the centres of each
// overlapping pair.
import type { Boxes, Camera } from '../numbers/boxes';
import { projection } from '../numbers/boxes';
import { resolved } from './colours';

// A corner is numbered by three bits (x, y, z); the two ends of an edge differ in one bit.
const EDGES = Array.from({ length: 8 }, (_, from) => [1, 2, 4].filter((bit) => (from & bit) === 0).map((bit) => [from, from | bit] as const)).flat();

interface Size { readonly width: number; readonly height: number } // in CSS pixels

function framesOf(boxes: Boxes, camera: Camera, { width, height }: Size): { plain: Path2D; overlapping: Path2D; pairs: Path2D } {
  const project = projection(camera, boxes.low, boxes.high, width, height);
  const paths = { plain: new Path2D(), overlapping: new Path2D(), pairs: new Path2D() };
  const pixels = Array.from({ length: 8 }, () => ({ x: 0, y: 0 }));
  for (let box = 0; box < boxes.count; ++box) {
    const at = (corner: number, axis: number) => boxes.corners[6 * box + axis + ((corner >> axis) & 1 ? 3 : 0)]!;
    pixels.forEach((pixel, corner) => project(at(corner, 0), at(corner, 1), at(corner, 2), pixel));
    const path = boxes.overlaps[box] ? paths.overlapping : paths.plain;
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

export function drawBoxes(canvas: HTMLCanvasElement, boxes: Boxes, camera: Camera, size: Size): void {
  const scale = Math.min(devicePixelRatio || 1, 2);
  canvas.width = Math.round(size.width * scale);
  canvas.height = Math.round(size.height * scale);
  const pen = canvas.getContext('2d');
  if (!pen) return;
  pen.scale(scale, scale);
  const { plain, overlapping, pairs } = framesOf(boxes, camera, size);
  pen.globalAlpha = boxes.count > 1000 ? 0.35 : 0.7;
  pen.strokeStyle = resolved('var(--soft)');
  pen.lineWidth = 0.75;
  pen.stroke(plain);
  pen.strokeStyle = resolved('var(--bad)');
  pen.stroke(overlapping);
  pen.globalAlpha = 1;
  pen.strokeStyle = resolved('var(--accent)');
  pen.lineWidth = 1.5;
  pen.stroke(pairs);
}
