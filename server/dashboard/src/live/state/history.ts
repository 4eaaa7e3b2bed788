// Posteriors over time: a bounded series per scene. When it is full, its older half is thinned to the points where an arm's mean is
// extreme. So no peak is lost, and memory does not grow with the time that the page is open.
import type { ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { keepExtremes } from '../numbers/downsample';
import { mean, type Posterior } from '../numbers/beta';

export const MAX_POINTS = 256;

export interface ArmPoint extends Posterior { readonly best?: number } // P(best); absent: unknown

export interface HistoryRow {
  readonly timeMs: number; // since 1970, by the daemon's clock
  readonly expectedLossRatio: number;
  readonly arms: readonly (ArmPoint | undefined)[]; // in the order of SceneHistory.arms; shorter if later arms were unknown then
}

export interface SceneHistory {
  readonly arms: readonly string[]; // in the order in which they became known
  readonly rows: readonly HistoryRow[]; // oldest first
}

export const NO_HISTORY: SceneHistory = { arms: [], rows: [] };

/** Returns the leader's P(best) over time, oldest first. */
export const trendOf = ({ rows }: SceneHistory): number[] =>
  rows.map(({ arms }) => Math.max(0, ...arms.map((arm) => arm?.best ?? 0))).filter((best) => best > 0);

const isSame = (a: HistoryRow | undefined, b: HistoryRow) => a !== undefined && a.arms.length === b.arms.length
  && b.arms.every((arm, i) => arm?.alpha === a.arms[i]?.alpha && arm?.beta === a.arms[i]?.beta && arm?.best === a.arms[i]?.best);

function thinned(rows: readonly HistoryRow[], armCount: number): readonly HistoryRow[] {
  if (rows.length < MAX_POINTS) return rows;
  const older = rows.slice(0, MAX_POINTS / 2);
  const means = Array.from({ length: armCount }, (_, i) => older.map(({ arms }) => arms[i] && mean(arms[i])));
  const kept = keepExtremes(older.map(({ timeMs }) => timeMs), means, MAX_POINTS / 4);
  return [...kept.map((i) => older[i]!), ...rows.slice(MAX_POINTS / 2)];
}

// Adds the posteriors of the scene's arms at `timeMs`, in the newest version of each arm. Adds nothing if nothing has changed.
export function addToHistory({ arms: known, rows }: SceneHistory, scene: ScenePosterior, timeMs: number): SceneHistory {
  const points = new Map<string, ArmPoint>();
  for (const { arm, posterior, isOutdated, bestProbability: best } of scene.arms) {
    if (posterior && !isOutdated) points.set(arm, { ...posterior, ...(best !== undefined && { best }) });
  }
  const arms = [...known, ...[...points.keys()].filter((arm) => !known.includes(arm))];
  const row = { timeMs, expectedLossRatio: scene.expectedLossRatio, arms: arms.map((arm) => points.get(arm)) };
  if (points.size === 0 || isSame(rows.at(-1), row)) return { arms, rows };
  return { arms, rows: thinned([...rows, row], arms.length) };
}

export interface SeriesRow {
  timeMs: number;
  beliefs: readonly (Posterior | undefined)[]; // in the order of the arms; undefined before an arm's first evidence
  best: readonly (number | undefined)[];
  expectedLossRatio: number | undefined;
}

/** Returns a row for each row of the history, oldest first. */
export function seriesOf({ arms: known, rows }: SceneHistory, arms: readonly string[]): SeriesRow[] {
  const places = arms.map((arm) => known.indexOf(arm));
  return rows.map(({ timeMs, expectedLossRatio, arms: told }) => {
    const own = places.map((place) => told[place]);
    const best = own.map((arm) => arm?.best);
    const isLearnt = best.some((each) => each !== undefined);
    return { timeMs, beliefs: own, best, expectedLossRatio: isLearnt ? expectedLossRatio : undefined };
  });
}
