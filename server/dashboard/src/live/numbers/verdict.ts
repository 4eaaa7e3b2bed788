// What the posteriors of a scene say, computed as `sweepstake watch` does (engine_client/cli/daemon/posterior_view.h): from the
// evidence of all sessions together, as if their windows were independent, with the newest version of each arm's backend only.
import type { ArmPosterior, ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { type Beta } from './beta';
import { diagnose, diagnoseLogCosts, type Diagnosis, NOTHING_LEARNT, nothingLearnt } from './best';
import { beliefOf, costRatioOf, LOG_COST_REWARD_VERSION, type Ratio } from './log_cost';

/** From here on a scene is stable (paper §7.1). */
export const STABLE_PROBABILITY = 0.8;
/** Up to here a scene that is not stable is a tie. */
export const TIE_LOSS_RATIO = 0.005;

/** What is computed for an arm. Absent: nothing is known, or its backend has a newer version. */
export interface ArmView {
  bestProbability?: number;
  costRatio?: Ratio; // ÷ the leader's cost; absent as well where rewards do not tell costs
}

export interface SceneVerdict {
  verdict: Verdict;
  leader: string; // '': nothing is learnt
  leaderProbability: number;
  expectedLossRatio: number;
  valueRemainingRatio: number;
  arms: readonly ArmView[]; // in the order of the scene's arms
}

export function verdictOfLeader(probability: number, expectedLossRatio: number): Verdict {
  if (probability >= STABLE_PROBABILITY) return Verdict.STABLE;
  return expectedLossRatio <= TIE_LOSS_RATIO ? Verdict.TIE : Verdict.AMBIGUOUS;
}

/** Diagnoses posteriors of this version of the reward. */
export function diagnoseRewards(posteriors: readonly Beta[], rewardVersion: number): Diagnosis {
  if (posteriors.length === 0 || nothingLearnt(posteriors)) return NOTHING_LEARNT;
  return rewardVersion === LOG_COST_REWARD_VERSION ? diagnoseLogCosts(posteriors.map(beliefOf)) : diagnose(posteriors);
}

const isUsable = (posterior: Beta | undefined): posterior is Beta =>
  posterior !== undefined && [posterior.alpha, posterior.beta].every((shape) => Number.isFinite(shape) && shape > 0);

export const isNewest = (arms: readonly ArmPosterior[], { arm, backendVersion }: ArmPosterior) =>
  !arms.some((other) => other.arm === arm && other.backendVersion > backendVersion);

function armView(posterior: Beta, leader: Beta, bestProbability: number, tellsCosts: boolean): ArmView {
  if (!tellsCosts) return { bestProbability };
  return { bestProbability, costRatio: posterior === leader ? { median: 1, low: 1, high: 1 } : costRatioOf(posterior, leader) };
}

const UNKNOWN = { verdict: Verdict.UNSPECIFIED, leader: '', leaderProbability: 0, expectedLossRatio: 0, valueRemainingRatio: 0 };

function computed({ arms, rewardVersion }: ScenePosterior): SceneVerdict {
  const views: ArmView[] = arms.map(() => ({}));
  const contenders: { place: number; posterior: Beta }[] = [];
  arms.forEach((arm, place) => {
    if (isUsable(arm.posterior) && isNewest(arms, arm)) contenders.push({ place, posterior: arm.posterior });
  });
  // The only arm that is known of is no better than others.
  const diagnosis = contenders.length < 2 ? NOTHING_LEARNT : diagnoseRewards(contenders.map(({ posterior }) => posterior), rewardVersion);
  if (diagnosis.bestProbability.length === 0) return { ...UNKNOWN, arms: views };
  const leader = contenders[diagnosis.leader]!;
  contenders.forEach(({ place, posterior }, i) => {
    views[place] = armView(posterior, leader.posterior, diagnosis.bestProbability[i]!, rewardVersion === LOG_COST_REWARD_VERSION);
  });
  const leaderProbability = diagnosis.bestProbability[diagnosis.leader]!;
  return {
    verdict: verdictOfLeader(leaderProbability, diagnosis.expectedLossRatio),
    leader: arms[leader.place]!.arm,
    leaderProbability,
    expectedLossRatio: diagnosis.expectedLossRatio,
    valueRemainingRatio: diagnosis.valueRemainingRatio,
    arms: views,
  };
}

const known = new WeakMap<ScenePosterior, SceneVerdict>();

/** Computed once per message. */
export function verdictOf(scene: ScenePosterior): SceneVerdict {
  const before = known.get(scene);
  if (before) return before;
  const verdict = computed(scene);
  known.set(scene, verdict);
  return verdict;
}
