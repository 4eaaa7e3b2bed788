// Rewards of version 3 are logarithms of costs: a reward r is 1 − ln(detection time in ns) / ln(5 s in ns). A Beta posterior
// approximates a normal belief about the logarithm of the cost (engine_client/decider/policy/log_cost.h). Rewards of other versions
// cannot be converted to costs.
import { significant } from '../../format';
import { type Beta, mean } from './beta';

export const LOG_COST_REWARD_VERSION = 3;
const LOG_RANGE = Math.log(5e9); // ln(5 s ÷ 1 ns): the range of log-costs from reward 1 to reward 0
const MAX_EVIDENCE = 1e12; // limit of α + β, for variances near 0
const DEVIATIONS_95 = 1.959963984540054; // half width of a central 95 % interval, in standard deviations

/** Median and the bounds of the central 95 % interval. */
export interface Ratio { median: number; low: number; high: number }

/** Returns the detection time in nanoseconds that has this reward. */
export const costNsOf = (reward: number) => Math.exp((1 - reward) * LOG_RANGE);
/** Returns the reward of a detection time in nanoseconds. */
export const rewardOfNs = (ns: number) => Math.min(Math.max(1 - Math.log(ns) / LOG_RANGE, 0), 1);

/**
 * Returns α + β, at least 1, of a Beta distribution with the mean `reward`. Its variance is that of a reward whose log-cost has the
 * variance `logCostVariance`.
 */
export function evidenceOf(reward: number, logCostVariance: number): number {
  const variance = logCostVariance / (LOG_RANGE * LOG_RANGE);
  const spread = reward * (1 - reward);
  return spread < MAX_EVIDENCE * variance ? Math.max(spread / variance, 1) : MAX_EVIDENCE;
}

/** Returns a time as text, such as "35.2 µs". */
export function nsText(ns: number): string {
  if (ns < 999.5) return `${significant(ns)} ns`;
  return ns < 999.5e3 ? `${significant(ns / 1e3)} µs` : `${significant(ns / 1e6)} ms`;
}

/** Returns a reward as text: as a detection time if rewards stand for costs. */
export const rewardText = (reward: number, tellsCosts: boolean) => (tellsCosts ? nsText(costNsOf(reward)) : significant(reward, 4));

/** Returns mean and variance of ln(cost in nanoseconds) under the posterior. */
export function beliefOf(posterior: Beta): { mean: number; variance: number } {
  const at = mean(posterior);
  return { mean: (1 - at) * LOG_RANGE, variance: ((at * (1 - at)) / (posterior.alpha + posterior.beta + 1)) * LOG_RANGE * LOG_RANGE };
}

/** Returns the ratio of an arm's cost to the leader's cost, for two independent posteriors. */
export function costRatioOf(arm: Beta, leader: Beta): Ratio {
  const cost = beliefOf(arm);
  const least = beliefOf(leader);
  const difference = cost.mean - least.mean;
  const reach = DEVIATIONS_95 * Math.sqrt(cost.variance + least.variance);
  return { median: Math.exp(difference), low: Math.exp(difference - reach), high: Math.exp(difference + reach) };
}
