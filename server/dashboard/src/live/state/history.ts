// How posteriors came to be what they are: a bounded series per arm. When it is full its older half is thinned, of every four points
// the two that are extreme, so that no peak is lost and a page that is left open for a week takes no more memory than one of an hour.
import type { ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';

export const MAX_POINTS = 256;

// Columns of equal length, oldest first. They grow and are thinned in place: copy what is to be kept as it is.
export interface ArmHistory {
  timesMs: number[];  // by the daemon's clock, since 1970
  alpha: number[];
  beta: number[];
}

// By arm. Versions of an arm's backend: the newest one only.
export type SceneHistory = ReadonlyMap<string, ArmHistory>;

function thin(history: ArmHistory): void {
  const mean = (i: number) => history.alpha[i]! / (history.alpha[i]! + history.beta[i]!);
  const kept: number[] = [];
  const half = history.timesMs.length - (history.timesMs.length % 8) >> 1;
  for (let first = 0; first < half; first += 4) {
    const group = [first, first + 1, first + 2, first + 3].sort((a, b) => mean(a) - mean(b) || a - b);
    kept.push(...[group[0]!, group[3]!].sort((a, b) => a - b));
  }
  for (let i = half; i < history.timesMs.length; ++i) kept.push(i);
  history.timesMs = kept.map((i) => history.timesMs[i]!);
  history.alpha = kept.map((i) => history.alpha[i]!);
  history.beta = kept.map((i) => history.beta[i]!);
}

function append(history: ArmHistory, timeMs: number, alpha: number, beta: number): void {
  const last = history.timesMs.length - 1;
  if (history.alpha[last] === alpha && history.beta[last] === beta) return;
  history.timesMs.push(timeMs);
  history.alpha.push(alpha);
  history.beta.push(beta);
  if (history.timesMs.length >= MAX_POINTS) thin(history);
}

// Adds what the scene's arms are believed to be at `timeMs`. An arm that has not changed gets no point: it is what its last one says.
export function addToHistory(history: SceneHistory, scene: ScenePosterior, timeMs: number): SceneHistory {
  const next = new Map(history);
  const newest = new Map(scene.arms.map((arm) => [arm.arm, Math.max(...scene.arms.filter((other) => other.arm === arm.arm)
    .map(({ backendVersion }) => backendVersion))]));
  for (const arm of scene.arms) {
    if (!arm.posterior || arm.backendVersion !== newest.get(arm.arm)) continue;
    if (!next.has(arm.arm)) next.set(arm.arm, { timesMs: [], alpha: [], beta: [] });
    append(next.get(arm.arm)!, timeMs, arm.posterior.alpha, arm.posterior.beta);
  }
  return next;
}
