// How certain the choice of an arm is: the probability of each arm to be the best, what choosing the leader loses, and what knowing
// all would gain, as engine_client/decider/policy/diagnosis.h has them. The leader is the arm with the highest probability, the first one
// of equals. Deterministic; right for α = 1e12 and for 32 arms.
import { type Beta, bounded, logitLogPeak, logitLogShape, logitMode, mean, mirrored } from './beta';
import { integrateMaximum, type LogDensity, NEGLIGIBLE, type ValueScale, type Variables } from './maximum';

/** A normal belief of the logarithm of a cost. */
export interface Normal { readonly mean: number; readonly variance: number }

export interface Diagnosis {
  /** In the order of the arms, of sum 1. Empty: nothing is learnt. */
  bestProbability: number[];
  leader: number;
  /** The share by which choosing the leader is worse than the best arm, on average. */
  expectedLossRatio: number;
  /** What perfect information would gain over the arm with the best mean. */
  valueRemainingRatio: number;
}

export const NOTHING_LEARNT: Diagnosis = { bestProbability: [], leader: 0, expectedLossRatio: 0, valueRemainingRatio: 0 };

/** Returns whether every posterior is Beta(1,1). */
export const nothingLearnt = (posteriors: readonly Beta[]) => posteriors.every(({ alpha, beta }) => alpha === 1 && beta === 1);

// The offset above the mode from where on the density is nothing. Newton's steps on a concave function begin beyond and stay there.
function negligibleAbove(p: Beta): number {
  const n = p.alpha + p.beta;
  const at = p.alpha / n;
  let offset = Math.sqrt(((-2 * NEGLIGIBLE) / p.alpha) * (n / p.beta)) - NEGLIGIBLE / p.beta;
  for (let i = 0; i < 100; ++i) {
    const excess = logitLogShape(p, offset) - NEGLIGIBLE;
    if (excess > -4) break;
    const y = (1 - at) / (1 - at + at * Math.exp(offset));
    offset -= excess / (n * y - p.beta);
  }
  return offset;
}

/** Returns the logits outside of which the density is nothing. */
export function logitSupport(posterior: Beta): [low: number, high: number] {
  const p = bounded(posterior);
  return [logitMode(p) - negligibleAbove(mirrored(p)), logitMode(p) + negligibleAbove(p)];
}

// Rewards on the scale of logits, as offsets t from the mode of the reward with the highest low end, where most digits are needed.
class BetaRewards implements Variables {
  readonly supports: { low: number; high: number; logPeak: number }[];
  private readonly rewards: { p: Beta; atOrigin: number }[];
  private readonly mirror: boolean; // the mean at the origin is above ½
  private readonly originSmall: number; // the smaller one of that mean and its complement
  private t = 0;
  private x = 0.5;
  private y = 0.5;
  private logRatio = 0; // growth of ln(1 + e^±t) since the origin

  constructor(posteriors: readonly Beta[]) {
    const all = posteriors.map(bounded);
    const supports = all.map(logitSupport);
    const first = supports.reduce((best, [low], index) => (low > supports[best]![0] ? index : best), 0);
    const at = all[first]!;
    const origin = logitMode(at);
    this.mirror = at.alpha > at.beta;
    this.originSmall = Math.min(at.alpha, at.beta) / (at.alpha + at.beta);
    this.supports = all.map((p, i) => ({ low: supports[i]![0] - origin, high: supports[i]![1] - origin, logPeak: logitLogPeak(p) }));
    this.rewards = all.map((p) => ({ p, atOrigin: logitLogShape(p, origin - logitMode(p)) }));
  }

  moveTo(t: number): void {
    this.t = t;
    const along = this.mirror ? -t : t;
    let small = 1;
    let large = 0;
    if (along < 700) {
      const growth = this.originSmall * Math.expm1(along);
      this.logRatio = Math.log1p(growth);
      small = (this.originSmall + growth) / (1 + growth);
      large = (1 - this.originSmall) / (1 + growth);
    } else {
      this.logRatio = along + Math.log(this.originSmall);
    }
    [this.x, this.y] = this.mirror ? [large, small] : [small, large];
  }

  scale(): ValueScale {
    const { x, y } = this;
    return { value: x, rate: x * y, slope: y - x, curvature: -2 * x * y };
  }

  at(variable: number): LogDensity {
    const { p, atOrigin } = this.rewards[variable]!;
    const n = p.alpha + p.beta;
    const along = this.mirror ? -p.beta * this.t : p.alpha * this.t;
    return {
      relative: Math.min(0, atOrigin + along - n * this.logRatio),
      slope: this.mirror ? n * this.y - p.beta : p.alpha - n * this.x,
      curvature: -n * this.x * this.y,
    };
  }
}

// Normal log-costs, negated so that the highest is the best, as offsets from the lowest mean.
class NormalCosts implements Variables {
  readonly supports: { low: number; high: number; logPeak: number }[];
  private readonly costs: { mean: number; precision: number }[];
  private t = 0;

  constructor(beliefs: readonly Normal[]) {
    const origin = Math.min(...beliefs.map((belief) => belief.mean));
    const variances = beliefs.map(({ variance }) => Math.max(variance, 1e-18));
    this.costs = beliefs.map((belief, i) => ({ mean: origin - belief.mean, precision: 1 / variances[i]! }));
    this.supports = this.costs.map((cost, i) => {
      const reach = Math.sqrt(-2 * NEGLIGIBLE * variances[i]!);
      return { low: cost.mean - reach, high: cost.mean + reach, logPeak: -0.5 * Math.log(2 * Math.PI * variances[i]!) };
    });
  }

  moveTo(t: number): void { this.t = t; }
  scale(): ValueScale { return { value: this.t, rate: 1, slope: 0, curvature: 0 }; }
  at(variable: number): LogDensity {
    const { mean: centre, precision } = this.costs[variable]!;
    const slope = (centre - this.t) * precision;
    return { relative: 0.5 * slope * (this.t - centre), slope, curvature: -precision };
  }
}

function diagnosis(bestProbability: number[], loss: (leader: number) => number, remaining: number): Diagnosis {
  const leader = bestProbability.indexOf(Math.max(...bestProbability));
  return { bestProbability, leader, expectedLossRatio: Math.max(loss(leader), 0), valueRemainingRatio: Math.max(remaining, 0) };
}

/** Diagnoses independent rewards, of which the highest is the best; losses are shares of the best reward. */
export function diagnose(posteriors: readonly Beta[]): Diagnosis {
  if (nothingLearnt(posteriors)) return NOTHING_LEARNT;
  const { probability, expectedValue } = integrateMaximum(new BetaRewards(posteriors));
  const highest = Math.max(...posteriors.map(mean));
  const best = Math.max(expectedValue, highest);
  if (!(best > 0)) return diagnosis(probability, () => 0, 0);
  return diagnosis(probability, (leader) => (best - mean(posteriors[leader]!)) / best, (best - highest) / best);
}

/** Diagnoses independent log-costs, of which the lowest is the best; losses are shares of the best arm's cost. */
export function diagnoseLogCosts(beliefs: readonly Normal[]): Diagnosis {
  if (beliefs.length === 0) return NOTHING_LEARNT;
  const { probability, expectedValue } = integrateMaximum(new NormalCosts(beliefs));
  const lowest = Math.min(...beliefs.map((belief) => belief.mean));
  return diagnosis(probability, (leader) => Math.expm1(expectedValue + (beliefs[leader]!.mean - lowest)), Math.expm1(expectedValue));
}

/** Returns the probability of each arm to be the best. */
export const bestProbabilities = (arms: readonly Beta[]) => diagnose(arms).bestProbability;
/** Returns what choosing the leader loses, as a share of the best reward. */
export const expectedLoss = (arms: readonly Beta[]) => diagnose(arms).expectedLossRatio;
