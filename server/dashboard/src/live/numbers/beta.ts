// The shape of a Beta density, for drawing. The figures of a scene come from the daemon; the values computed here are accurate to a
// pixel. Pure functions. Parameters are from 1 to 1e15, which covers Beta(1, 1) plus evidence; others are clamped to that range.

export interface Beta { readonly alpha: number; readonly beta: number }
/** The lower and the upper end. */
export type Interval = readonly [number, number];

const MIN_SHAPE = 1;
const MAX_SHAPE = 1e15;
const REACH = 10; // range of the grid on each side of the mode, in standard deviations; less than 3e-4 of the mass is outside
const STEPS = 240; // number of intervals of the grid

const bound = (shape: number) => Math.min(Math.max(shape, MIN_SHAPE), MAX_SHAPE);
export const mean = ({ alpha, beta }: Beta) => alpha / (alpha + beta);

// On the scale of logits, t = ln(x / (1 − x)), the density has one peak, at the logit of the mean.
export const logitMode = ({ alpha, beta }: Beta) => Math.log(bound(alpha)) - Math.log(bound(beta));
/** Returns the standard deviation of the normal distribution on the scale of logits that has the same curvature at the peak. */
export const logitDeviation = ({ alpha, beta }: Beta) => Math.sqrt(1 / bound(alpha) + 1 / bound(beta));

/** Returns ln(density of logits ÷ its peak), `offset` from the mode. Computed relative to the mode, since α ln x and β ln(1 − x) would cancel. */
export function logitLogShape(posterior: Beta, offset: number): number {
  const [alpha, beta] = [bound(posterior.alpha), bound(posterior.beta)];
  const [small, large, along] = alpha <= beta ? [alpha, beta, offset] : [beta, alpha, -offset];
  const ratio = small / (small + large);
  const logRatio = along < 700 ? Math.log1p(ratio * Math.expm1(along)) : along + Math.log(ratio);
  return Math.min(0, small * along - (small + large) * logRatio);
}

/** Returns the reward at a logit. */
export function rewardAt(logit: number): number {
  const e = Math.exp(-Math.abs(logit));
  return logit < 0 ? e / (1 + e) : 1 / (1 + e);
}

/** Returns the quantiles of the reward at these probabilities, from a sum over a grid of logits. REQUIRES: `shares` ascend. */
export function quantiles(posterior: Beta, shares: readonly number[]): number[] {
  const step = (2 * REACH * logitDeviation(posterior)) / STEPS;
  const offsets = Array.from({ length: STEPS + 1 }, (_, i) => (i - STEPS / 2) * step);
  const heights = offsets.map((offset) => Math.exp(logitLogShape(posterior, offset)));
  const total = heights.reduce((sum, height) => sum + height, 0);
  let i = 0;
  let below = 0; // the sum of the heights before index i
  return shares.map((share) => {
    while (i < STEPS && below + heights[i]! < share * total) below += heights[i++]!;
    return rewardAt(logitMode(posterior) + offsets[i]! + step * ((share * total - below) / heights[i]! - 0.5));
  });
}

/** Returns the central interval that contains the reward with this probability, such as 0.95. */
export function centralInterval(posterior: Beta, mass: number): Interval {
  const [low, high] = quantiles(posterior, [(1 - mass) / 2, (1 + mass) / 2]);
  return [low!, high!];
}
