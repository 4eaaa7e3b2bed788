// Where two builds of a game say something else of what arms cost, computed as `sweepstake priors diff` does (engine_client/cli/priors/):
// from the evidence of each build alone, in the newest version of each arm, as costs relative to the scene's cheapest arm.
import type { PriorRecord } from '../../gen/sweepstake/v1/priors_pb';
import { costRatioOf, evidenceOf, LOG_COST_REWARD_VERSION, type Ratio } from './log_cost';

/** What measures beside the frame thread, in visits; the frame thread has no name. */
export const LANE = 'lane';
/** The logarithm of a cost ratio up to which two builds say the same. */
export const SAME_LOG_RATIO = 0.05;
const LANE_BIAS_VARIANCE = 0.15 ** 2; // engine_client/decider/policy/log_cost.h

/** Sums of increments, without any prior. */
export interface Sum { readonly alpha: number; readonly beta: number }

export interface ArmEvidence {
  readonly live: Sum; // windows, and the penalties of bail-outs
  readonly lane: Sum;
  readonly bailOutCount: number; // of those penalties
}

/** A part of the evidence: whose and of what, and how much. */
export interface Taught extends Sum {
  readonly example: Pick<PriorRecord, 'project' | 'scene' | 'build' | 'machineClass' | 'rewardVersion' | 'arm' | 'backendVersion' | 'measuredBy'>;
  readonly bailOutCount: number;
}

/** An arm's cost ÷ the cheapest one's, in one build and in the other; absent where that knows nothing of it. */
export interface ArmChange { readonly arm: string; readonly before?: Ratio; readonly after?: Ratio }

export interface SceneChange {
  readonly project: string;
  readonly scene: string;
  readonly machineClass: string;
  readonly arms: readonly ArmChange[]; // ordered by name
  readonly leader: 'same' | 'other' | 'in one'; // whether an arm is the cheapest one in both builds; one of them may know nothing
}

const NOTHING: Sum = { alpha: 0, beta: 0 };
const weightOf = ({ alpha, beta }: Sum) => alpha + beta;
const isKnown = (sum: Sum) => weightOf(sum) > 0;
const meanOf = (sum: Sum) => sum.alpha / weightOf(sum);
const together = (a: Sum, b: Sum): Sum => ({ alpha: a.alpha + b.alpha, beta: a.beta + b.beta });

// By how much the windows' mean rewards exceed those of the visits.
function levelOf(arms: readonly ArmEvidence[]): number {
  const excess = arms.filter(({ live, lane, bailOutCount }) => isKnown(live) && isKnown(lane) && bailOutCount === 0)
    .map(({ live, lane }) => meanOf(live) - meanOf(lane));
  return excess.length > 0 ? excess.reduce((sum, each) => sum + each, 0) / excess.length : 0;
}

/** Returns what windows and visits together say of each arm: engine_client/decider/policy/scene_prior.h, PoolEvidence. */
export function pooled(arms: readonly ArmEvidence[]): Sum[] {
  const level = levelOf(arms);
  return arms.map(({ live, lane, bailOutCount }) => {
    if (!isKnown(lane)) return live;
    const visited = Math.min(Math.max(meanOf(lane) + level, 0), 1);
    const mean = bailOutCount > 0 ? Math.min(visited, meanOf(live)) : visited;
    const weight = 1 / (1 / weightOf(lane) + 1 / evidenceOf(mean, LANE_BIAS_VARIANCE)) + weightOf(live);
    return { alpha: weight * mean, beta: weight * (1 - mean) };
  });
}

type Ratios = ReadonlyMap<string, Ratio>; // by arm

const CHEAPEST: Ratio = { median: 1, low: 1, high: 1 };

/** Returns the cost of each arm with evidence ÷ that of the cheapest one, which has no interval. REQUIRES: rewards of version 3. */
export function costRatios(arms: ReadonlyMap<string, ArmEvidence>): Ratios {
  const sums = pooled([...arms.values()]);
  const known = [...arms.keys()].map((arm, i) => [arm, sums[i]!] as const).filter(([, sum]) => isKnown(sum));
  const most = Math.max(...known.map(([, sum]) => meanOf(sum)));
  const leader = known.find(([, sum]) => meanOf(sum) === most)?.[1];
  return new Map(known.map(([arm, sum]) => [arm, meanOf(sum) === most ? CHEAPEST : costRatioOf(sum, leader!)]));
}

interface SceneArms {
  place: Omit<SceneChange, 'arms' | 'leader'>;
  arms: Map<string, ArmEvidence & { version: number }>; // each in its newest version
}

function addTo(arms: SceneArms['arms'], { example: { arm, backendVersion, measuredBy }, alpha, beta, bailOutCount }: Taught): void {
  const known = arms.get(arm);
  if (known && known.version > backendVersion) return;
  const before = known?.version === backendVersion ? known : { version: backendVersion, live: NOTHING, lane: NOTHING, bailOutCount: 0 };
  const more = { alpha, beta };
  arms.set(arm, measuredBy === LANE
    ? { ...before, lane: together(before.lane, more) }
    : { ...before, live: together(before.live, more), bailOutCount: before.bailOutCount + bailOutCount });
}

/** Returns what was taught of each arm of one scene, in its newest version. */
export function evidenceByArm(taught: Iterable<Taught>): ReadonlyMap<string, ArmEvidence> {
  const arms: SceneArms['arms'] = new Map();
  for (const each of taught) addTo(arms, each);
  return arms;
}

// What a build says of each scene on each class of machines, as far as its rewards tell costs.
function scenesOf(taught: Iterable<Taught>, build: string): Map<string, SceneArms> {
  const scenes = new Map<string, SceneArms>();
  for (const each of taught) {
    const { project, scene, machineClass, rewardVersion } = each.example;
    if (each.example.build !== build || rewardVersion !== LOG_COST_REWARD_VERSION) continue;
    const key = [project, scene, machineClass].join('\n');
    if (!scenes.has(key)) scenes.set(key, { place: { project, scene, machineClass }, arms: new Map() });
    addTo(scenes.get(key)!.arms, each);
  }
  return scenes;
}

/** Whether two builds say something else of an arm, or only one of them knows it. */
export const isChange = ({ before, after }: ArmChange) =>
  (before === undefined || after === undefined ? before !== after : Math.abs(Math.log(after.median / before.median)) > SAME_LOG_RATIO);

function changeOf(place: SceneArms['place'], before: Ratios, after: Ratios): SceneChange {
  const arms = [...new Set([...before.keys(), ...after.keys()])].sort().map((arm): ArmChange => ({
    arm, ...(before.has(arm) && { before: before.get(arm)! }), ...(after.has(arm) && { after: after.get(arm)! }),
  }));
  const leader = before.size === 0 || after.size === 0 ? 'in one' : arms.some((arm) => arm.before?.median === 1 && arm.after?.median === 1) ? 'same' : 'other';
  return { ...place, arms, leader };
}

const NO_RATIOS: Ratios = new Map();
const ratiosIn = (scenes: ReadonlyMap<string, SceneArms>, key: string) => (scenes.has(key) ? costRatios(scenes.get(key)!.arms) : NO_RATIOS);

// By how much, as a logarithm, the most different arm of a scene differs; of an arm that only one knows nothing can be said.
const sizeOf = ({ arms }: SceneChange) =>
  Math.max(0, ...arms.map(({ before, after }) => (before && after ? Math.abs(Math.log(after.median / before.median)) : 0)));

const LEADER_ORDER: readonly SceneChange['leader'][] = ['other', 'same', 'in one'];

/** Orders scenes so that those come first where another arm is the cheapest one, then those where costs differ most, and last those of one build. */
export const byWeight = (a: SceneChange, b: SceneChange) =>
  LEADER_ORDER.indexOf(a.leader) - LEADER_ORDER.indexOf(b.leader) || sizeOf(b) - sizeOf(a) || a.scene.localeCompare(b.scene);

/** Returns the scenes in which an arm is a change from the one build to the other, with all their arms. */
export function buildChanges(taught: Iterable<Taught>, before: string, after: string): SceneChange[] {
  const all = [...taught];
  const olds = scenesOf(all, before);
  const news = scenesOf(all, after);
  return [...new Map([...olds, ...news])].map(([key, { place }]) => changeOf(place, ratiosIn(olds, key), ratiosIn(news, key)))
    .filter(({ arms }) => arms.some(isChange));
}
