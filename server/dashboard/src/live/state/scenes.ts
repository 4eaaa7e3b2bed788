// The scenes of the daemon, as in its last message.
import { signal } from '@preact/signals';
import type { ArmPosterior, DecisionEvent, ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { bestDiffer, surenessOf } from './regimes';

const MAX_SCENE_DECISIONS = 500;

// Bounds of the page's memory. The page may be open for weeks, with any number of scenes and sessions.
export const MAX_DECISIONS = 20_000;
const MIN_SHARE = 20;

// Returns how many decisions each of `count` scenes or sessions may keep (at most `most`), so that all together keep about MAX_DECISIONS.
export const shareOf = (count: number, most: number) =>
  Math.max(MIN_SHARE, Math.min(most, Math.floor(MAX_DECISIONS / Math.max(count, 1))));

export interface SceneState {
  key: string;
  posterior: ScenePosterior;
  // Time at which the page received the last change, by the browser's clock. Before the first change: time at which a session last added
  // evidence, by the daemon's clock. 0: unknown.
  changedMs: number;
  decisions: readonly DecisionEvent[];  // oldest first; up to MAX_SCENE_DECISIONS, fewer if there are many scenes
}

// The key of a posterior: a scene has one for each class of machines and version of the reward.
export interface SceneName {
  project: string;
  scene: string;
  machineClass: string;
  rewardVersion: number;
}

/** All scenes by sceneKey. Only this file changes the map. */
export const scenes = signal<ReadonlyMap<string, SceneState>>(new Map());

// Key of the scene that a view shows; '': none. This scene keeps MAX_SCENE_DECISIONS decisions even if there are many scenes.
export const sceneInView = signal('');

// Names contain no control characters, so '\n' separates them.
export const sceneKey = ({ project, scene, machineClass, rewardVersion }: SceneName) =>
  [project, scene, machineClass, rewardVersion].join('\n');

/** The leader's probability of being the best arm. If the best arm depends on the regime: the lowest of the regimes. 0 if not known. */
export const leaderProbabilityOf = (posterior: ScenePosterior) =>
  (bestDiffer(posterior) ? posterior.activity ? surenessOf(posterior.activity) : 0
    : posterior.arms.find(({ arm, isOutdated }) => arm === posterior.leaderArm && !isOutdated)?.bestProbability ?? 0);

/** When a source last added evidence of the arm, by the daemon's clock; 0: unknown. */
export const lastSeenMs = ({ unixLastSeenS }: Pick<ArmPosterior, 'unixLastSeenS'>) => 1000 * Number(unixLastSeenS);

// Returns the states of the scenes by their keys. Known scenes keep their decisions.
const statesOf = (posteriors: readonly ScenePosterior[], areNew: boolean) => posteriors.map((posterior): [string, SceneState] => {
  const key = sceneKey(posterior);
  const { changedMs = 0, decisions = [] } = scenes.peek().get(key) ?? {};
  return [key, { key, posterior, changedMs: areNew ? Date.now() : Math.max(changedMs, ...posterior.arms.map(lastSeenMs)), decisions }];
});

export function takeSnapshot(posteriors: readonly ScenePosterior[]): void {
  scenes.value = new Map(statesOf(posteriors, false));
}

export function takeChanges(posteriors: readonly ScenePosterior[], decisions: readonly DecisionEvent[]): void {
  const next = new Map([...scenes.peek(), ...statesOf(posteriors, true)]);
  addDecisions(next, groupedBy(decisions, sceneKey), MAX_SCENE_DECISIONS, sceneInView.peek(), { changedMs: Date.now() });
  scenes.value = next;
}

/** Adds decisions to states; ignores unknown keys. Each state keeps its share of MAX_DECISIONS; the one in view keeps `most`. */
export function addDecisions<State extends Pick<SceneState, 'decisions'>>(all: Map<string, State>, added: ReadonlyMap<string, readonly DecisionEvent[]>,
  most: number, inView: string, change: Partial<State> = {}): void {
  const share = shareOf(all.size, most);
  for (const [key, own] of added) {
    const state = all.get(key);
    if (state) all.set(key, { ...state, ...change, decisions: [...state.decisions, ...own].slice(key === inView ? -most : -share) });
  }
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
