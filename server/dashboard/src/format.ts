// Formats numbers for display.
const NONE = '–';
const SMALLEST = -9;  // smaller powers of ten are written with an exponent

const isNumber = (value: number | null | undefined): value is number => typeof value === 'number' && Number.isFinite(value);

export function significant(value: number | null | undefined, digits = 3): string {
  if (!isNumber(value)) return NONE;
  if (value === 0) return '0';
  const rounded = Number(value.toPrecision(digits));
  const first = Math.floor(Math.log10(Math.abs(rounded)) + 1e-9);
  return first < SMALLEST ? rounded.toExponential(digits - 1) : rounded.toFixed(Math.max(0, digits - 1 - first));
}

export const grouped = (value: number) => (isNumber(value) ? String(Math.round(value)).replace(/\B(?=(\d{3})+(?!\d))/g, ',') : NONE);

// Divides by 1000 until the rounded value is below 1000, at most `most` times. Returns the quotient and the number of divisions.
function thousands(value: number, most: number): [number, number] {
  let steps = 0;
  while (steps < most && Math.abs(value) >= 999.5) {
    value /= 1000;
    ++steps;
  }
  return [value, steps];
}

export function compact(value: number): string {
  if (!isNumber(value)) return NONE;
  const [rest, steps] = thousands(value, 3);
  return significant(rest).replace(/\.0+$|(\.\d*[1-9])0+$/, '$1') + ['', 'k', 'M', 'G'][steps];
}

export function bytes(value: number): string {
  if (!isNumber(value)) return NONE;
  const [rest, steps] = thousands(value, 4);
  return (steps === 0 ? rest.toFixed(0) : significant(rest)) + [' B', ' kB', ' MB', ' GB', ' TB'][steps];
}

export const times = (ratio: number) => (isNumber(ratio) ? `${significant(ratio)}×` : NONE);
export const milliseconds = (ms: number) => significant(ms);

// Returns a ratio as a percentage: with two decimals below 10 %, one below 100 %, none above. REQUIRES: ratio >= 0.
export function share(ratio: number): string {
  if (!isNumber(ratio)) return NONE;
  const size = 100 * ratio;
  if (size < 9.995) return `${size.toFixed(2)} %`;
  if (size < 99.95) return `${size.toFixed(1)} %`;
  return `${grouped(size)} %`;
}

// Returns a ratio as a percentage with a sign, unless it rounds to zero.
export function percent(ratio: number | null): string {
  if (!isNumber(ratio)) return NONE;
  const size = share(Math.abs(ratio));
  return /[1-9]/.test(size) ? (ratio < 0 ? '−' : '+') + size : '0 %';
}

export type Interval = [number, number];
export const interval = ([low, high]: Interval) => `${percent(low)} to ${percent(high)}`;
export const probability = (p: number) => (p < 0.0001 ? '< 0.0001' : significant(p, 2));
export const counted = (count: number, one: string, many: string) => `${grouped(count)} ${count === 1 ? one : many}`;

export function mean(values: readonly number[]): number {
  return values.reduce((sum, value) => sum + value, 0) / values.length;
}
