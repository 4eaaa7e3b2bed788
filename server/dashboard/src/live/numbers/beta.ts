// The Beta distribution of an arm's reward: density, distribution function and quantiles, by the formulas of
// engine_client/math/beta_distribution.h, so that the page and the daemon give the same figures. Pure functions. Parameters from
// 1e-6 to 1e15; one outside counts as the nearer bound. Error of cdf: 1e-8 relative up to 1e12, where the rounding of x is worth most of
// it; quantile has that of cdf.

export interface Beta { readonly alpha: number; readonly beta: number }
/** Low and high end. */
export type Interval = readonly [number, number];

const MIN_SHAPE = 1e-6;
const MAX_SHAPE = 1e15;
const HALF_LOG_2_PI = 0.9189385332046728;
const STIRLING_FROM = 15; // from here on Stirling's series up to x^-11 is exact to the last place
const SUM_FROM = 3000; // from here on a tail is integrated, since its series has too many terms
const PRECISION = 1e-17;

const bound = (shape: number) => Math.min(Math.max(shape, MIN_SHAPE), MAX_SHAPE);
/** Returns the posterior with both parameters within the bounds. */
export const bounded = ({ alpha, beta }: Beta): Beta => ({ alpha: bound(alpha), beta: bound(beta) });
/** Returns the distribution of 1 − the reward. */
export const mirrored = ({ alpha, beta }: Beta): Beta => ({ alpha: beta, beta: alpha });
export const mean = ({ alpha, beta }: Beta) => alpha / (alpha + beta);
/** The paper's n, prior included. */
export const evidence = ({ alpha, beta }: Beta) => alpha + beta;

const stirlingLeading = (x: number) => (x - 0.5) * Math.log(x) - x + HALF_LOG_2_PI;

function stirlingSeries(x: number): number {
  const square = 1 / (x * x);
  const terms = [1 / 12, -1 / 360, 1 / 1260, -1 / 1680, 1 / 1188, -691 / 360360];
  return terms.reduceRight((sum, term) => sum * square + term, 0) / x;
}

/** Returns ln Γ(x). REQUIRES: x > 0. */
export function logGamma(x: number): number {
  let product = 1;
  let shifted = x;
  for (; shifted < STIRLING_FROM; ++shifted) product *= shifted;
  return stirlingLeading(shifted) + stirlingSeries(shifted) - Math.log(product);
}

// ln Γ(x) − stirlingLeading(x), where the large parts cancel.
const stirlingError = (x: number) => (x >= STIRLING_FROM ? stirlingSeries(x) : logGamma(x) - stirlingLeading(x));

// On the scale of logits, t = ln(x / (1 − x)), the density is exp(logitLogPeak + logitLogShape(t − logitMode)): its only peak is at
// the mode, where x is the mean.
export const logitMode = (p: Beta) => Math.log(bound(p.alpha)) - Math.log(bound(p.beta));

export function logitLogPeak(posterior: Beta): number {
  const { alpha, beta } = bounded(posterior);
  const n = alpha + beta;
  return 0.5 * Math.log((alpha / n) * beta) - HALF_LOG_2_PI + stirlingError(n) - stirlingError(alpha) - stirlingError(beta);
}

/** <= 0, concave, 0 at the offset 0. Computed from the mode on, since the terms of α ln x + β ln(1 − x) would cancel. */
export function logitLogShape(posterior: Beta, offset: number): number {
  const p = bounded(posterior);
  const [small, large, along] = p.alpha <= p.beta ? [p.alpha, p.beta, offset] : [p.beta, p.alpha, -offset];
  const n = small + large;
  const ratio = small / n;
  const logRatio = along < 700 ? Math.log1p(ratio * Math.expm1(along)) : along + Math.log(ratio);
  return Math.min(0, small * along - n * logRatio);
}

// The point of [0, 1] at a logit, and 1 − the point with all its digits.
function fromLogit(logit: number): [x: number, y: number] {
  const e = Math.exp(-Math.abs(logit));
  return logit < 0 ? [e / (1 + e), 1 / (1 + e)] : [1 / (1 + e), e / (1 + e)];
}

/** Returns the reward at a logit. */
export const rewardAt = (logit: number) => fromLogit(logit)[0];

/** Returns the logarithm of the density of rewards at x. REQUIRES: 0 < x < 1. */
export function logDensity(posterior: Beta, x: number): number {
  const logX = Math.log(x);
  const logY = Math.log1p(-x);
  return logitLogPeak(posterior) + logitLogShape(posterior, logX - logY - logitMode(posterior)) - logX - logY;
}

// The series of I_x(α, β) ÷ (x^α (1 − x)^β / (α B)) (DLMF 8.17.8). All terms are positive; around the mean it takes some √α of them.
function incompleteSeries(p: Beta, x: number): number {
  const n = p.alpha + p.beta;
  let term = 1;
  let sum = 1;
  for (let k = 0; term > PRECISION * sum; ++k) {
    term *= ((n + k) / (p.alpha + 1 + k)) * x;
    sum += term;
  }
  return sum;
}

// P(logit <= mode + offset) by the trapezoidal rule, with Euler's and Maclaurin's terms at the end up to the third derivative. A
// step is a twelfth of the scale on which the density changes. REQUIRES: offset <= 0, α >= 1, both parameters large or the logit > 0.
function summedTail(p: Beta, offset: number): number {
  const n = p.alpha + p.beta;
  const [x, y] = fromLogit(logitMode(p) + offset);
  const slope = p.alpha * y - p.beta * x; // of the density's logarithm
  const h = 1 / (12 * Math.max(1, Math.sqrt((p.alpha / n) * p.beta), slope / 8));
  let sum = 0;
  let term = 1;
  for (let i = 1; term > PRECISION * sum; ++i) {
    term = Math.exp(logitLogShape(p, offset - i * h));
    sum += term;
  }
  const first = h * slope;
  const second = -h * h * n * x * y;
  const third = second * h * (y - x);
  const endTerms = 0.5 - first / 12 + (first * (first * first + 3 * second) + third) / 720;
  return Math.exp(logitLogPeak(p)) * h * (sum + endTerms * Math.exp(logitLogShape(p, offset)));
}

// P(logit <= mode + offset) by the series. REQUIRES: the logit is at most 0.
function seriesTail(p: Beta, offset: number): number {
  const logShape = logitLogShape(p, offset);
  if (offset > 0 && logShape < -45) return 1;
  return (Math.exp(logitLogPeak(p) + logShape) / p.alpha) * incompleteSeries(p, rewardAt(logitMode(p) + offset));
}

// P(logit <= mode + offset). Below the mean it is the lower tail, above it 1 − the upper one, so that small results have all digits.
function tailAt(p: Beta, offset: number): number {
  const large = Math.min(p.alpha, p.beta) > SUM_FROM;
  if (!large && logitMode(p) + offset <= 0) return seriesTail(p, offset);
  if (offset <= 0 && p.alpha >= 1) return summedTail(p, offset);
  return 1 - (large ? summedTail(mirrored(p), -offset) : seriesTail(mirrored(p), -offset));
}

const massBelow = (p: Beta, offset: number) => Math.min(Math.max(tailAt(p, offset), 0), 1);

/** Returns P(reward <= x), the regularised incomplete beta function. */
export function cdf(posterior: Beta, x: number): number {
  if (!(x > 0)) return 0;
  if (x >= 1) return 1;
  const p = bounded(posterior);
  return massBelow(p, Math.log(x) - Math.log1p(-x) - logitMode(p));
}

// The quantile of a normal distribution to 5e-4 (Abramowitz and Stegun 26.2.23). REQUIRES: 0 < p <= 0.5.
function roughNormalQuantile(p: number): number {
  const t = Math.sqrt(-2 * Math.log(p));
  return (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308))) - t;
}

// The offset from the mode below which the distribution has mass p. The logarithm of the distribution function is concave, so that
// Newton's steps come to it from below wherever they begin: at that of the normal distribution with the curvature of the peak,
// which is near it where the evidence is large. REQUIRES: 0 < p <= 0.5.
function offsetOfLowerTail(p: Beta, mass: number): number {
  const logPeak = logitLogPeak(p);
  const deviation = 1 / Math.sqrt((p.alpha / (p.alpha + p.beta)) * p.beta);
  let offset = deviation < 0.3 ? deviation * roughNormalQuantile(mass) : 0;
  let step = 0;
  for (let i = 0; i < 100; ++i) {
    const below = massBelow(p, offset);
    const density = Math.exp(logPeak + logitLogShape(p, offset));
    // An empty tail means that the last step was too long.
    step = below > 0 && density > 0 ? (Math.log(mass) - Math.log(below)) * (below / density) : Math.abs(step) / 2;
    offset += step;
    if (Math.abs(step) <= 1e-13 * Math.abs(offset)) break;
  }
  return offset;
}

/** Returns the reward below which the arm is with probability p; 0 if it is too small for a double. */
export function quantile(posterior: Beta, p: number): number {
  if (!(p > 0)) return 0;
  if (p >= 1) return 1;
  const b = bounded(posterior);
  return rewardAt(logitMode(b) + (p <= 0.5 ? offsetOfLowerTail(b, p) : -offsetOfLowerTail(mirrored(b), 1 - p)));
}

/** Returns the central interval that has the reward with this probability, such as 0.95; both tails are equal. */
export const centralInterval = (posterior: Beta, mass: number): Interval =>
  [quantile(posterior, (1 - mass) / 2), quantile(posterior, (1 + mass) / 2)];
