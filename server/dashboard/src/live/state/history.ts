// How posteriors came to be what they are: a bounded series per scene. When it is full its older half is thinned to the points where an
// arm's mean is extreme, so that no peak is lost and a page that is left open for a week takes no more memory than one of an hour.
import type { ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { type Beta, mean } from '../numbers/beta';
import { keepExtremes } from '../numbers/downsample';

export const MAX_POINTS = 256;

export interface ArmPoint extends Beta { readonly best?: number } // P(best); absent: not known

export interface HistoryRow {
  readonly timeMs: number; // by the daemon's clock, since 1970
  readonly expectedLossRatio: number;
  readonly arms: readonly (ArmPoint | undefined)[]; // in the order of SceneHistory.arms, as far as they were known then
}

export interface SceneHistory {
  readonly arms: readonly string[]; // in the order in which they became known
  readonly rows: readonly HistoryRow[]; // oldest first
}

export const NO_HISTORY: SceneHistory = { arms: [], rows: [] };

const isSame = (a: HistoryRow | undefined, b: HistoryRow) => a !== undefined && a.arms.length === b.arms.length
  && b.arms.every((arm, i) => arm?.alpha === a.arms[i]?.alpha && arm?.beta === a.arms[i]?.beta && arm?.best === a.arms[i]?.best);

function thinned(rows: readonly HistoryRow[], armCount: number): readonly HistoryRow[] {
  if (rows.length < MAX_POINTS) return rows;
  const older = rows.slice(0, MAX_POINTS / 2);
  const means = Array.from({ length: armCount }, (_, i) => older.map(({ arms }) => arms[i] && mean(arms[i])));
  const kept = keepExtremes(older.map(({ timeMs }) => timeMs), means, MAX_POINTS / 4);
  return [...kept.map((i) => older[i]!), ...rows.slice(MAX_POINTS / 2)];
}

// Adds what the scene's arms are believed to be at `timeMs`, in their newest versions. Where nothing has changed, nothing is added.
export function addToHistory({ arms: known, rows }: SceneHistory, scene: ScenePosterior, timeMs: number): SceneHistory {
  const points = new Map<string, ArmPoint>();
  for (const { arm, posterior, isOutdated, bestProbability: best } of scene.arms) {
    if (posterior && !isOutdated) points.set(arm, { alpha: posterior.alpha, beta: posterior.beta, ...(best !== undefined && { best }) });
  }
  const arms = [...known, ...[...points.keys()].filter((arm) => !known.includes(arm))];
  const row = { timeMs, expectedLossRatio: scene.expectedLossRatio, arms: arms.map((arm) => points.get(arm)) };
  if (points.size === 0 || isSame(rows.at(-1), row)) return { arms, rows };
  return { arms, rows: thinned([...rows, row], arms.length) };
}
