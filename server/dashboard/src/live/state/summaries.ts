// The rows of the overview, one per scene. They are updated at most every half second, and only for scenes that changed.
import { effect, signal, untracked } from '@preact/signals';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { isChanging } from './regimes';
import { leaderProbabilityOf, scenes, type SceneState } from './scenes';
import { isConnected, sessions, type SessionState } from './sessions';

const INTERVAL_MS = 500;

/** 'changing': the best arm depends on the regime of the scene. The daemon's verdict is about all evidence together. */
export type SceneVerdict = Verdict | 'changing';

export type SceneSummary = ReturnType<typeof summaryOf>;

/** The summaries of all scenes. Only this file changes the list. */
export const summaries = signal<readonly SceneSummary[]>([]);

const RANKS: Readonly<Record<SceneVerdict, number>> = {
  [Verdict.DEGRADED]: 4, [Verdict.AMBIGUOUS]: 3, [Verdict.UNSPECIFIED]: 2, [Verdict.TIE]: 1, changing: 1, [Verdict.STABLE]: 0,
};

// Returns whether the last verdict of a connected session is DEGRADED, which a posterior never is: it depends on a frame rate.
export function isDegraded({ decisions }: Pick<SceneState, 'decisions'>, all: ReadonlyMap<string, SessionState>): boolean {
  const last = new Map(decisions.map(({ sessionId, verdict }) => [sessionId, verdict]));
  return [...last].some(([id, verdict]) => {
    const session = all.get(id);
    return verdict === Verdict.DEGRADED && session !== undefined && isConnected(session);
  });
}

/** Returns the verdict of the posterior, DEGRADED if a session reports that, or 'changing'. */
export function verdictOf(state: SceneState): SceneVerdict {
  if (isDegraded(state, sessions.value)) return Verdict.DEGRADED;
  const { posterior } = state;
  return isChanging(posterior) ? 'changing' : posterior.verdict;
}

// `evidence` counts windows and lane visits of all arms. Degraded scenes have the highest uncertainty, then uncertain ones.
export function summaryOf(state: SceneState) {
  const { posterior } = state;
  const leaderProbability = leaderProbabilityOf(posterior);
  const verdict = verdictOf(state);
  return {
    state, leaderProbability, verdict,
    evidence: posterior.arms.reduce((sum, { windowCount, visitCount }) => sum + windowCount + visitCount, 0n),
    uncertainty: RANKS[verdict] * 10 + (posterior.leaderArm || verdict === 'changing' ? 1 - leaderProbability : 0),
  };
}

let timer: ReturnType<typeof setTimeout> | undefined;

const update = () => untracked(() => {
  timer = undefined;
  const before = new Map(summaries.peek().map((summary) => [summary.state.key, summary]));
  summaries.value = [...scenes.peek().values()].map((state) => {
    const known = before.get(state.key);
    return known?.state === state && known.verdict !== Verdict.DEGRADED ? known : summaryOf(state);
  });
});

export function followScenes(): void {
  effect(() => {
    if (scenes.value.size === 0 && summaries.peek().length === 0) return;
    if (summaries.peek().length === 0) update();
    else timer ??= setTimeout(update, INTERVAL_MS);
  });
}
