// Computes ticks and domains of axes. On logarithmic axes Plot itself labels either every digit or only the decades.
import * as Plot from '@observablehq/plot';

const MIN_FACTOR = 4; // minimum ratio of the ends of an axis

// Returns a range slightly larger than that of the values. Values without a logarithm are ignored.
export function logDomain(values: number[], margin = 1.25): [number, number] {
  const positive = values.filter((value) => value > 0 && Number.isFinite(value));
  if (positive.length === 0) return [1, 10];
  let low = Math.min(...positive) / margin;
  let high = Math.max(...positive) * margin;
  const factor = high / low;
  if (factor < MIN_FACTOR) {
    const grow = Math.sqrt(MIN_FACTOR / factor);
    [low, high] = [low / grow, high * grow];
  }
  return [low, high];
}

// Returns the powers of ten in the range, and 2 and 5 times each of them if there is room.
export function logTicks([low, high]: [number, number]): number[] {
  const decades = Math.log10(high / low);
  const step = Math.max(1, Math.round(decades / 6));
  const digits = decades > 3.5 ? [1] : [1, 2, 5];
  const ticks: number[] = [];
  for (let decade = Math.floor(Math.log10(low)); decade <= Math.log10(high); ++decade) {
    if (decade % step !== 0) continue;
    for (const digit of digits) {
      const tick = Number(`${digit}e${decade}`);
      if (tick >= low && tick <= high) ticks.push(tick);
    }
  }
  return ticks;
}

export const linearTicks = ([low, high]: [number, number]) =>
  Array.from({ length: 11 }, (_, i) => low + (i * (high - low)) / 10).map((tick) => Number(tick.toPrecision(3)));

// Returns an axis with labels at `ticks`, and grid lines across the picture.
export function axes(side: 'x' | 'y', ticks: number[], format: (tick: number) => string, label: string): Plot.Markish[] {
  const options = { text: format, label, labelAnchor: 'center', labelArrow: false } as const;
  return side === 'x' ? [Plot.gridX(ticks), Plot.axisX(ticks, options)] : [Plot.gridY(ticks), Plot.axisY(ticks, options)];
}

// Moves positions apart, so that each has `height` of room within `[top, bottom]`. Keeps their order and stays near the wanted positions.
export function spreadOut(wanted: number[], height: number, top: number, bottom: number): number[] {
  const order = wanted.map((_, index) => index).sort((a, b) => wanted[a]! - wanted[b]!);
  const placed = [...wanted];
  let low = top;
  for (const index of order) low = (placed[index] = Math.max(placed[index]!, low)) + height;
  let high = bottom;
  for (const index of order.reverse()) high = (placed[index] = Math.min(placed[index]!, high)) - height;
  return placed;
}
