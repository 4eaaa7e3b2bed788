// The outline of a posterior's density along an axis of rewards. It is computed from the logarithm of the density, so that the narrow
// peak of a posterior with α = 1e12 is drawn correctly.
import { type Beta, centralInterval, logitDeviation, logitLogShape, logitMode, mean, rewardAt } from './beta';

/** The density at a reward ÷ the highest density, from 0 to 1. */
export interface RidgePoint { reward: number; height: number }

const NEEDLE_POINTS = 48; // additional points around the peak
const NEEDLE_DEVIATIONS = 6; // range of these points on each side of the peak, in standard deviations

// Returns the logarithm of the density of rewards, not normalized. REQUIRES: 0 < reward < 1.
function logDensity(posterior: Beta, reward: number): number {
  const [logX, logY] = [Math.log(reward), Math.log1p(-reward)];
  return logitLogShape(posterior, logX - logY - logitMode(posterior)) - logX - logY;
}

/** Returns points of ascending reward within [low, high]: `count` evenly spaced ones, and more around the peak. */
export function ridge(posterior: Beta, low: number, high: number, count: number): RidgePoint[] {
  const deviation = logitDeviation(posterior);
  const peak = logitMode(posterior);
  const rewards = [
    ...Array.from({ length: count }, (_, i) => low + ((high - low) * (i + 0.5)) / count),
    ...Array.from({ length: NEEDLE_POINTS + 1 }, (_, i) => rewardAt(peak + deviation * NEEDLE_DEVIATIONS * ((2 * i) / NEEDLE_POINTS - 1))),
  ].filter((reward) => reward > 0 && reward < 1).sort((a, b) => a - b);
  const logs = rewards.map((reward) => logDensity(posterior, reward));
  const highest = Math.max(...logs);
  return rewards.map((reward, i) => ({ reward, height: Math.exp(logs[i]! - highest) })).filter(({ reward }) => reward >= low && reward <= high);
}

/** Returns an axis that contains 99.8 % of each measured posterior. Posteriors that were never measured are ignored. */
export function ridgeAxis(posteriors: readonly { posterior: Beta; isMeasured: boolean }[]): [low: number, high: number] {
  const measured = posteriors.filter(({ isMeasured }) => isMeasured);
  if (measured.length === 0) return [0, 1];
  const ends = measured.map(({ posterior }) => centralInterval(posterior, 0.998));
  const means = measured.map(({ posterior }) => mean(posterior));
  const low = Math.min(...ends.map((end) => end[0]), ...means);
  const high = Math.max(...ends.map((end) => end[1]), ...means);
  const pad = Math.max(0.06 * (high - low), 1e-9);
  return [Math.max(0, low - pad), Math.min(1, high + pad)];
}

/** Returns about `count` round numbers within [low, high]. */
export function linearTicks(low: number, high: number, count: number): number[] {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => each >= rough) ?? rough;
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
