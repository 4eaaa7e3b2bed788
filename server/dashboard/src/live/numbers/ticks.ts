// The ticks of axes.

/** Rounds to 1, 2 or 5 times a power of ten: up if `isUp`, else down. */
export function rounded(value: number, isUp: boolean): number {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  const steps = [1, 2, 5, 10].map((step) => step * power);
  return (isUp ? steps.find((step) => step >= value * (1 - 1e-9)) : steps.findLast((step) => step <= value * (1 + 1e-9))) ?? power;
}

/** Returns about `count` round numbers within [low, high]. */
export function linearTicks(low: number, high: number, count: number): number[] {
  const step = rounded((high - low) / Math.max(count, 1), true);
  const ticks: number[] = [];
  for (let k = Math.ceil(low / step); k * step <= high && ticks.length < 100; ++k) ticks.push(k * step);
  return ticks;
}

/** Returns ticks of a logarithmic axis: 1, 2 and 5 times powers of ten, or only some powers of ten if there are more than `count`.
 * Returns linear ticks if high ÷ low is below 5. */
export function logTicks(low: number, high: number, count: number): number[] {
  if (high / low < 5) return linearTicks(low, high, count);
  const all: number[] = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); ++power) all.push(...[1, 2, 5].map((factor) => factor * 10 ** power));
  const within = all.filter((value) => value >= low && value <= high);
  const powersOnly = within.filter((value) => Math.abs(Math.log10(value) % 1) < 1e-9);
  if (within.length <= count || powersOnly.length < 2) return within;
  const step = Math.ceil(powersOnly.length / Math.max(count, 1));
  return powersOnly.filter((_, i) => i % step === 0);
}
