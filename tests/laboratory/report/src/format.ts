// Formats the numbers that only the report has.
import { share, signedShare, significant } from '../../../../server/dashboard/src/format';

export const times = (ratio: number) => (Number.isFinite(ratio) ? `${significant(ratio)}×` : significant(ratio));
export const milliseconds = (ms: number) => significant(ms);
export const microseconds = (ns: number) => `${significant(ns * 1e-3)} µs`;

const NOISE_MS = 1e-12; // smaller differences are rounding errors of one that is 0
// Returns a difference of milliseconds with its sign.
export const signedMs = (ms: number) => (Math.abs(ms) < NOISE_MS ? '0' : (ms < 0 ? '−' : '+') + significant(Math.abs(ms)));

// Returns a ratio as a percentage with a sign, unless it rounds to zero.
export function percent(ratio: number | null): string {
  if (ratio === null || !Number.isFinite(ratio)) return significant(null);
  const text = signedShare(ratio);
  return ratio > 0 && text !== '0 %' ? `+${text}` : text;
}

export type Interval = [number, number];
export const interval = ([low, high]: Interval) => `${percent(low)} to ${percent(high)}`;
export const probability = (p: number) => (p < 0.0001 ? '< 0.0001' : significant(p, 2));

export const shareInterval = ([low, high]: Interval) => `${share(Math.max(low, 0))} to ${share(Math.max(high, 0))}`;

// Returns "12.2±2.8", both with `decimals` decimals; for a single value only "12.2".
export const spread = (value: number, deviation: number, count: number, decimals: number) =>
  (Number.isFinite(value) ? value.toFixed(decimals) + (count > 1 && Number.isFinite(deviation) ? `±${deviation.toFixed(decimals)}` : '') : significant(value));
