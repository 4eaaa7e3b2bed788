// Converts rewards of version 3 to detection times and back: a reward r is 1 − ln(detection time in ns) / ln(5 s in ns)
// (engine_client/decider/policy/log_cost.h). Rewards of other versions do not depend on the cost alone.
import { significant } from '../../format';

export const LOG_COST_REWARD_VERSION = 3;
export const NS_PER_MS = 1e6;
/** The time of a frame at 60 frames per second. */
export const FRAME_MS = 1000 / 60;
const LOG_RANGE = Math.log(5e9); // ln(5 s ÷ 1 ns): the range of log-costs from reward 1 to reward 0

/** Median and the bounds of the central 95 % interval. */
export interface Ratio { median: number; low: number; high: number }

export const costNsOf = (reward: number) => Math.exp((1 - reward) * LOG_RANGE);
export const rewardOfNs = (ns: number) => Math.min(Math.max(1 - Math.log(ns) / LOG_RANGE, 0), 1);

/** Returns a time as text, such as "35.2 µs", in the unit of the time `like`. */
export function nsText(ns: number, like = ns): string {
  if (like < 999.5) return `${significant(ns)} ns`;
  return like < 999.5e3 ? `${significant(ns / 1e3)} µs` : `${significant(ns / 1e6)} ms`;
}

/** Returns a reward as text: as a detection time if rewards stand for costs. */
export const rewardText = (reward: number, tellsCosts: boolean) => (tellsCosts ? nsText(costNsOf(reward)) : significant(reward, 4));
