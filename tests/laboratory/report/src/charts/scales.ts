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

// Returns multiples of 1, 2 or 5 times a power of ten in the range, at most `most` + 1 of them.
export function linearTicks([low, high]: [number, number], most = 10): number[] {
  const exact = (high - low) / most;
  const decade = 10 ** Math.floor(Math.log10(exact));
  const step = decade * [1, 2, 5, 10].find((digit) => digit * decade >= exact * (1 - 1e-9))!;
  const ticks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; ++i) ticks.push(Number((i * step).toPrecision(12)) + 0);
  return ticks;
}

// A symmetric logarithmic axis has negative values, too. It is about linear from −SYMLOG_LINEAR to SYMLOG_LINEAR and logarithmic beyond.
export const SYMLOG_LINEAR = 0.1;
const symlogPosition = (value: number) => Math.sign(value) * Math.log1p(Math.abs(value) / SYMLOG_LINEAR);
const LONG_SYMLOG = 12; // on a longer axis, the labels of ±SYMLOG_LINEAR would overlap that of 0 on a phone

// Returns a range slightly larger than that of the values and 0.
export function symlogDomain(values: number[], margin = 1.25): [number, number] {
  const finite = values.filter(Number.isFinite);
  const low = Math.min(0, ...finite) * margin;
  return [low, Math.max(0, ...finite) * margin || (low < 0 ? 0 : SYMLOG_LINEAR)];
}

// Returns 0 and the powers of ten from ±SYMLOG_LINEAR on in the range, or round numbers if the range is short. A long axis has no ticks at
// ±SYMLOG_LINEAR.
export function symlogTicks([low, high]: [number, number]): number[] {
  if (Math.max(high, -low) < 2 * SYMLOG_LINEAR) return linearTicks([low, high], 5);
  const powers: number[] = [];
  const first = symlogPosition(high) - symlogPosition(low) > LONG_SYMLOG ? 10 * SYMLOG_LINEAR : SYMLOG_LINEAR;
  for (let power = first; power <= Math.max(high, -low); power *= 10) powers.push(Number(power.toPrecision(1)));
  return [...powers.map((power) => -power).reverse(), 0, ...powers].filter((tick) => tick >= low && tick <= high);
}

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
