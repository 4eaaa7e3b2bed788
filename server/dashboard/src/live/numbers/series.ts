// How beliefs came to be what they are: for each time, the mean and the intervals of each arm, the probability to be the best, and what
// choosing the leader loses.
import type { SceneHistory } from '../state/history';
import { type Beta, centralInterval, mean } from './beta';
import { keepExtremes } from './downsample';
import { diagnoseRewards } from './verdict';

/** Of an arm's reward: mean, and where it is with 50 and 95 %. */
export interface Belief { mean: number; low50: number; high50: number; low95: number; high95: number }

export interface SeriesRow {
  timeMs: number;
  beliefs: readonly (Belief | undefined)[]; // in the order of the arms; undefined: not known yet
  best: readonly (number | undefined)[];
  expectedLossRatio: number | undefined;
}

const MAX_ROWS = 360;
const MAX_BELIEFS = 20_000;
const beliefs = new Map<string, Belief>();

export function beliefOf(posterior: Beta): Belief {
  const key = `${posterior.alpha} ${posterior.beta}`;
  const known = beliefs.get(key);
  if (known) return known;
  const [low50, high50] = centralInterval(posterior, 0.5);
  const [low95, high95] = centralInterval(posterior, 0.95);
  const belief = { mean: mean(posterior), low50, high50, low95, high95 };
  if (beliefs.size >= MAX_BELIEFS) beliefs.clear();
  beliefs.set(key, belief);
  return belief;
}

/** The posterior of each arm at each time: an arm keeps its last one until it has another. */
interface Held { timesMs: number[]; posteriors: (Beta | undefined)[][] }

function held(history: SceneHistory, arms: readonly string[]): Held {
  const timesMs = [...new Set([...history.values()].flatMap((each) => each.timesMs))].sort((a, b) => a - b);
  const posteriors = arms.map((arm) => {
    const own = history.get(arm);
    let place = -1;
    return timesMs.map((timeMs) => {
      while (own && place + 1 < own.timesMs.length && own.timesMs[place + 1]! <= timeMs) ++place;
      return own && place >= 0 ? { alpha: own.alpha[place]!, beta: own.beta[place]! } : undefined;
    });
  });
  return { timesMs, posteriors };
}

function rowOf(timeMs: number, posteriors: readonly (Beta | undefined)[], rewardVersion: number): SeriesRow {
  const known = posteriors.filter((each): each is Beta => each !== undefined);
  const diagnosis = known.length < 2 ? undefined : diagnoseRewards(known, rewardVersion);
  const probabilities = [...(diagnosis?.bestProbability ?? [])];
  const isLearnt = probabilities.length > 0;
  return {
    timeMs,
    beliefs: posteriors.map((each) => each && beliefOf(each)),
    best: posteriors.map((each) => (each && isLearnt ? probabilities.shift() : undefined)),
    expectedLossRatio: isLearnt ? diagnosis?.expectedLossRatio : undefined,
  };
}

/** Keeps what was computed, so that a new point costs one row. */
export class PosteriorSeries {
  private readonly rows = new Map<number, SeriesRow>();

  constructor(private readonly arms: readonly string[], private readonly rewardVersion: number) {}

  /** Returns up to MAX_ROWS rows, oldest first. */
  of(history: SceneHistory): SeriesRow[] {
    const { timesMs, posteriors } = held(history, this.arms);
    const means = posteriors.map((column) => column.map((each) => (each ? mean(each) : Number.NaN)));
    const kept = keepExtremes(timesMs, means, Math.max(MAX_ROWS, 2 + 2 * this.arms.length));
    const next = kept.map((i) => this.rows.get(timesMs[i]!) ?? rowOf(timesMs[i]!, posteriors.map((column) => column[i]), this.rewardVersion));
    this.rows.clear();
    for (const row of next) this.rows.set(row.timeMs, row);
    return next;
  }
}
