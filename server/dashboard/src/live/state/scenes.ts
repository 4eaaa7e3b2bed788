// The scenes that the daemon knows, as it last told.
import { signal, type ReadonlySignal } from '@preact/signals';
import type { ArmPosterior, DecisionEvent, ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { keepLast, shareOf } from './bounds';
import { addToHistory, NO_HISTORY, type SceneHistory } from './history';

export const MAX_SCENE_DECISIONS = 500;

export interface SceneState {
  key: string;
  posterior: ScenePosterior;
  // When the last change came, by the browser's clock, or, before one came, when sessions taught last, by the daemon's; 0: not known.
  changedMs: number;
  history: SceneHistory;
  decisions: readonly DecisionEvent[];  // oldest first; up to MAX_SCENE_DECISIONS, fewer where there are many scenes
}

// What names a scene: it has a posterior for each class of machines and version of the reward.
export interface SceneName {
  project: string;
  scene: string;
  machineClass: string;
  rewardVersion: number;
}

const held = signal<ReadonlyMap<string, SceneState>>(new Map());
export const scenes: ReadonlySignal<ReadonlyMap<string, SceneState>> = held;

// The scene that a view shows keeps all of its decisions however many scenes there are; '': none.
export const sceneInView = signal('');

// No name holds a control character.
export const sceneKey = ({ project, scene, machineClass, rewardVersion }: SceneName) =>
  [project, scene, machineClass, rewardVersion].join('\n');

// The policies that learn the logarithm of the cost, whose reward is version 3; all others of the daemon have version 1. See
// engine_client/decider/session/policy_registry.cc.
const LOG_COST_POLICIES = ['adaptive', 'calibrated', 'default'];
const rewardVersionOf = (policy: string) => (LOG_COST_POLICIES.includes(policy) ? 3 : 1);

export const sceneKeyOf = (event: DecisionEvent) => sceneKey({ ...event, rewardVersion: rewardVersionOf(event.policy) });

/** The leader's probability of being the best arm; 0: nothing is learnt. */
export const leaderProbabilityOf = ({ leaderArm, arms }: ScenePosterior) =>
  arms.find(({ arm, isOutdated }) => arm === leaderArm && !isOutdated)?.bestProbability ?? 0;

/** When a source of the arm taught last, by the daemon's clock; 0: not known. */
export const lastSeenMs = ({ unixLastSeenS }: ArmPosterior) => 1000 * Number(unixLastSeenS);

function withPosterior(state: SceneState | undefined, key: string, posterior: ScenePosterior, timeMs: number, isNew: boolean): SceneState {
  return {
    key,
    posterior,
    changedMs: isNew ? Date.now() : Math.max(state?.changedMs ?? 0, ...posterior.arms.map(lastSeenMs)),
    history: addToHistory(state?.history ?? NO_HISTORY, posterior, timeMs),
    decisions: state?.decisions ?? [],
  };
}

// Replaces all scenes by those of a snapshot; one that was known keeps its history.
export function takeSnapshot(posteriors: readonly ScenePosterior[], timeMs: number): void {
  const before = held.peek();
  held.value = new Map(posteriors.map((posterior) => {
    const key = sceneKey(posterior);
    return [key, withPosterior(before.get(key), key, posterior, timeMs, false)];
  }));
}

// Adds what changed. Decisions of scenes that are not known are left out.
export function takeChanges(posteriors: readonly ScenePosterior[], decisions: readonly DecisionEvent[], timeMs: number): void {
  const next = new Map(held.peek());
  for (const posterior of posteriors) {
    const key = sceneKey(posterior);
    next.set(key, withPosterior(next.get(key), key, posterior, timeMs, true));
  }
  const share = shareOf(next.size, MAX_SCENE_DECISIONS);
  for (const [key, added] of groupedBy(decisions, sceneKeyOf)) {
    const state = next.get(key);
    if (!state) continue;
    const limit = key === sceneInView.peek() ? MAX_SCENE_DECISIONS : share;
    next.set(key, { ...state, changedMs: Date.now(), decisions: keepLast(state.decisions, added, limit) });
  }
  held.value = next;
}

export function groupedBy<Item>(items: readonly Item[], keyOf: (item: Item) => string): Map<string, Item[]> {
  const groups = new Map<string, Item[]>();
  for (const item of items) {
    const group = groups.get(keyOf(item));
    if (group) group.push(item);
    else groups.set(keyOf(item), [item]);
  }
  return groups;
}
