// Posteriors over time: for each time the mean and the credible intervals of each arm, and the P(best) and loss from the daemon.
import type { SceneHistory } from '../state/history';
import { type Beta, mean, quantiles } from './beta';

/** An arm's reward: mean, and 50 % and 95 % credible intervals. */
export interface Belief { mean: number; low50: number; high50: number; low95: number; high95: number }

export interface SeriesRow {
  timeMs: number;
  beliefs: readonly (Belief | undefined)[]; // in the order of the arms; undefined before an arm's first evidence
  best: readonly (number | undefined)[];
  expectedLossRatio: number | undefined;
}

const MAX_BELIEFS = 20_000; // entries of the cache
const beliefs = new Map<string, Belief>();

export function beliefOf(posterior: Beta): Belief {
  const key = `${posterior.alpha} ${posterior.beta}`;
  const known = beliefs.get(key);
  if (known) return known;
  const [low95, low50, high50, high95] = quantiles(posterior, [0.025, 0.25, 0.75, 0.975]) as [number, number, number, number];
  const belief = { mean: mean(posterior), low50, high50, low95, high95 };
  if (beliefs.size >= MAX_BELIEFS) beliefs.clear();
  beliefs.set(key, belief);
  return belief;
}

/** Returns a row for each row of the history, oldest first. */
export function seriesOf({ arms: known, rows }: SceneHistory, arms: readonly string[]): SeriesRow[] {
  const places = arms.map((arm) => known.indexOf(arm));
  return rows.map(({ timeMs, expectedLossRatio, arms: told }) => {
    const own = places.map((place) => told[place]);
    const best = own.map((arm) => arm?.best);
    const isLearnt = best.some((each) => each !== undefined);
    return { timeMs, beliefs: own.map((arm) => arm && beliefOf(arm)), best, expectedLossRatio: isLearnt ? expectedLossRatio : undefined };
  });
}
