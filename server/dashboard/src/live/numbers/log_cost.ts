// Rewards of version 3 tell costs: a reward r is 1 − ln(detection time in ns) / ln(5 s in ns), and a Beta posterior stands for a
// normal belief of the logarithm of the cost (engine_client/decider/policy/log_cost.h). Rewards of other versions do not tell costs.
import { significant } from '../../format';
import { type Beta, mean } from './beta';

export const LOG_COST_REWARD_VERSION = 3;
const LOG_RANGE = Math.log(5e9); // the rewards from 1 to 0
const MAX_EVIDENCE = 1e12;
const DEVIATIONS_95 = 1.959963984540054;

/** Median, and the bounds that hold with a probability of 95 %. */
export interface Ratio { median: number; low: number; high: number }

/** Returns the detection time in nanoseconds that has this reward. */
export const costNsOf = (reward: number) => Math.exp((1 - reward) * LOG_RANGE);
/** Returns the reward of a detection time in nanoseconds. */
export const rewardOfNs = (ns: number) => Math.min(Math.max(1 - Math.log(ns) / LOG_RANGE, 0), 1);

/**
 * Returns α + β, at least 1, of the Beta distribution with this mean and the variance that a logarithm of a cost with this variance
 * gives a reward.
 */
export function evidenceOf(reward: number, logCostVariance: number): number {
  const variance = logCostVariance / (LOG_RANGE * LOG_RANGE);
  const spread = reward * (1 - reward);
  return spread < MAX_EVIDENCE * variance ? Math.max(spread / variance, 1) : MAX_EVIDENCE;
}

/** Returns a time as people read it: "35.2 µs". */
export function nsText(ns: number): string {
  if (ns < 999.5) return `${significant(ns)} ns`;
  return ns < 999.5e3 ? `${significant(ns / 1e3)} µs` : `${significant(ns / 1e6)} ms`;
}

/** Returns what a reward is called: the detection time, where rewards tell it. */
export const rewardText = (reward: number, tellsCosts: boolean) => (tellsCosts ? nsText(costNsOf(reward)) : significant(reward, 4));

/** Returns what the posterior says of the logarithm of the cost in nanoseconds. */
export function beliefOf(posterior: Beta): { mean: number; variance: number } {
  const at = mean(posterior);
  return { mean: (1 - at) * LOG_RANGE, variance: ((at * (1 - at)) / (posterior.alpha + posterior.beta + 1)) * LOG_RANGE * LOG_RANGE };
}

/** Returns an arm's cost ÷ the leader's, as two independent posteriors tell it. */
export function costRatioOf(arm: Beta, leader: Beta): Ratio {
  const cost = beliefOf(arm);
  const least = beliefOf(leader);
  const difference = cost.mean - least.mean;
  const reach = DEVIATIONS_95 * Math.sqrt(cost.variance + least.variance);
  return { median: Math.exp(difference), low: Math.exp(difference - reach), high: Math.exp(difference + reach) };
}
