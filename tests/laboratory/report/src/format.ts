// Formats the numbers that only the report has.
import { type Interval, share, significant } from '../../../../server/dashboard/src/format';

export const microseconds = (ns: number) => `${significant(ns * 1e-3)} µs`;

const NOISE_MS = 1e-12; // smaller differences are rounding errors of one that is 0
// Returns a difference of milliseconds with its sign.
export const signedMs = (ms: number) => (Math.abs(ms) < NOISE_MS ? '0' : (ms < 0 ? '−' : '+') + significant(Math.abs(ms)));

export const shareInterval = ([low, high]: Interval) => `${share(Math.max(low, 0))} to ${share(Math.max(high, 0))}`;

// Returns "12.2±2.8", both with `decimals` decimals; for a single value only "12.2".
export const spread = (value: number, deviation: number, count: number, decimals: number) =>
  (Number.isFinite(value) ? value.toFixed(decimals) + (count > 1 && Number.isFinite(deviation) ? `±${deviation.toFixed(decimals)}` : '') : significant(value));
