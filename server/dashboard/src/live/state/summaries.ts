// The rows of the overview, one per scene. They are updated at most every half second, and only for scenes that changed.
import { effect, signal, type ReadonlySignal } from '@preact/signals';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { leaderProbabilityOf, scenes, type SceneState } from './scenes';
import { isConnected, sessions, type SessionState } from './sessions';

const INTERVAL_MS = 500;
export const MAX_TREND = 64;

export interface SceneSummary {
  state: SceneState;
  leaderProbability: number;  // the leader's P(best); 0 without evidence
  verdict: Verdict;  // the verdict of the posterior, or DEGRADED if a session reports that
  trend: readonly number[];  // the leader's P(best), oldest first
  evidence: bigint;  // windows and lane visits of all arms
  uncertainty: number;  // sort key: degraded scenes are highest, then uncertain ones
}

const held = signal<readonly SceneSummary[]>([]);
export const summaries: ReadonlySignal<readonly SceneSummary[]> = held;

const RANKS: Readonly<Record<Verdict, number>> = {
  [Verdict.DEGRADED]: 4, [Verdict.AMBIGUOUS]: 3, [Verdict.UNSPECIFIED]: 2, [Verdict.TIE]: 1, [Verdict.STABLE]: 0,
};

// Returns the lowest and the highest of every four values.
export function thinned(values: readonly number[]): number[] {
  const kept: number[] = [];
  for (let first = 0; first < values.length; first += 4) {
    const group = values.slice(first, first + 4);
    const low = Math.min(...group);
    const high = Math.max(...group);
    kept.push(...(group.indexOf(low) <= group.indexOf(high) ? [low, high] : [high, low]));
  }
  return kept;
}

function withValue(trend: readonly number[], value: number): readonly number[] {
  const room = trend.length < MAX_TREND ? trend : thinned(trend);
  return [...room, value];
}

// Returns whether the last verdict of a connected session is DEGRADED. The posterior has no such verdict, because it depends on the
// frame rate of a session.
export function isDegraded({ decisions }: Pick<SceneState, 'decisions'>, all: ReadonlyMap<string, SessionState>): boolean {
  const last = new Map(decisions.map(({ sessionId, verdict }) => [sessionId, verdict]));
  return [...last].some(([id, verdict]) => {
    const session = all.get(id);
    return verdict === Verdict.DEGRADED && session !== undefined && isConnected(session);
  });
}

export function summaryOf(state: SceneState, before?: SceneSummary): SceneSummary {
  const { posterior } = state;
  const leaderProbability = leaderProbabilityOf(posterior);
  const verdict = isDegraded(state, sessions.peek()) ? Verdict.DEGRADED : posterior.verdict;
  const isNewPosterior = before?.state.posterior !== posterior;
  const trend = before?.trend ?? [];
  return {
    state, leaderProbability, verdict,
    trend: isNewPosterior && posterior.leaderArm ? withValue(trend, leaderProbability) : trend,
    evidence: posterior.arms.reduce((sum, { windowCount, visitCount }) => sum + windowCount + visitCount, 0n),
    uncertainty: RANKS[verdict] * 10 + (posterior.leaderArm ? 1 - leaderProbability : 0),
  };
}

let timer: ReturnType<typeof setTimeout> | undefined;

function update(): void {
  timer = undefined;
  const before = new Map(held.peek().map((summary) => [summary.state.key, summary]));
  held.value = [...scenes.peek().values()].map((state) => {
    const known = before.get(state.key);
    return known?.state === state && known.verdict !== Verdict.DEGRADED ? known : summaryOf(state, known);
  });
}

export function followScenes(): void {
  effect(() => {
    if (scenes.value.size === 0 && held.peek().length === 0) return;
    if (held.peek().length === 0) update();
    else timer ??= setTimeout(update, INTERVAL_MS);
  });
}
