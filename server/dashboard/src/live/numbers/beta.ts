// The shape of a Beta density, for drawing. The daemon computes intervals and all other figures. Pure functions. Parameters are from 1
// to 1e15, which covers Beta(1, 1) plus evidence; others are clamped to that range.

export interface Beta { readonly alpha: number; readonly beta: number }
/** A posterior with the ends of its central 50 % and 95 % intervals, as the daemon computed them. Absent: posteriors of the audit log. */
export interface Posterior extends Beta { readonly low95?: number; readonly low50?: number; readonly high50?: number; readonly high95?: number }

const MIN_SHAPE = 1;
const MAX_SHAPE = 1e15;
const REACH = 3.1; // range of an axis on each side of a density's peak, in standard deviations

const bound = (shape: number) => Math.min(Math.max(shape, MIN_SHAPE), MAX_SHAPE);
export const mean = ({ alpha, beta }: Beta) => alpha / (alpha + beta);

// On the scale of logits, t = ln(x / (1 − x)), the density has one peak, at the logit of the mean.
export const logitMode = ({ alpha, beta }: Beta) => Math.log(bound(alpha)) - Math.log(bound(beta));
/** Returns the standard deviation of the normal distribution on the scale of logits that has the same curvature at the peak. */
const logitDeviation = ({ alpha, beta }: Beta) => Math.sqrt(1 / bound(alpha) + 1 / bound(beta));

/** Returns ln(density of logits ÷ its peak), `offset` from the mode. Computed relative to the mode, since α ln x and β ln(1 − x) would cancel. */
function logitLogShape(posterior: Beta, offset: number): number {
  const [alpha, beta] = [bound(posterior.alpha), bound(posterior.beta)];
  const [small, large, along] = alpha <= beta ? [alpha, beta, offset] : [beta, alpha, -offset];
  const ratio = small / (small + large);
  const logRatio = along < 700 ? Math.log1p(ratio * Math.expm1(along)) : along + Math.log(ratio);
  return Math.min(0, small * along - (small + large) * logRatio);
}

export function rewardAt(logit: number): number {
  const e = Math.exp(-Math.abs(logit));
  return logit < 0 ? e / (1 + e) : 1 / (1 + e);
}

const NEEDLE_POINTS = 48; // additional points around the peak
const NEEDLE_DEVIATIONS = 6; // range of these points on each side of the peak, in standard deviations

// Returns the logarithm of the density of rewards, not normalized. REQUIRES: 0 < reward < 1.
function logDensity(posterior: Beta, reward: number): number {
  const [logX, logY] = [Math.log(reward), Math.log1p(-reward)];
  return logitLogShape(posterior, logX - logY - logitMode(posterior)) - logX - logY;
}

/** Returns points of ascending reward within [low, high]: `count` evenly spaced ones, and more around the peak. Heights are from 0 to 1. */
export function ridge(posterior: Beta, low: number, high: number, count: number): { reward: number; height: number }[] {
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

/** Returns an axis that contains the visible part of each measured density. Posteriors that were never measured are ignored. */
export function ridgeAxis(posteriors: readonly { posterior: Beta; isMeasured: boolean }[]): [low: number, high: number] {
  const measured = posteriors.filter(({ isMeasured }) => isMeasured).map(({ posterior }) => posterior);
  if (measured.length === 0) return [0, 1];
  const end = (posterior: Beta, deviations: number) => rewardAt(logitMode(posterior) + deviations * logitDeviation(posterior));
  const low = Math.min(...measured.map((posterior) => end(posterior, -REACH)));
  const high = Math.max(...measured.map((posterior) => end(posterior, REACH)));
  const pad = Math.max(0.06 * (high - low), 1e-9);
  return [Math.max(0, low - pad), Math.min(1, high + pad)];
}
