// The regimes of a scene, and what its sessions run now. The daemon computes all figures (engine_client/decider/policy/regime_report.h).
import type { RegimeArm, RegimePosterior, SceneActivity, ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { grouped, share, signedShare, significant } from '../../format';

export const bestOf = ({ arms, bestArm }: RegimePosterior, activity: SceneActivity): RegimeArm | undefined => arms[activity.arms.indexOf(bestArm)];

type Judged = Pick<ScenePosterior, 'activity' | 'regimeArms'>;

/** Returns the best arm of each regime, each arm once, in the order of the regimes; without a connected session, those of the stored
 * evidence. Empty if there is only one regime. */
export const regimeArms = ({ activity, regimeArms: stored }: Judged): string[] =>
  (activity ? [...new Set(activity.regimes.map(({ bestArm }) => bestArm))].filter(Boolean) : stored);

/** Returns the number of the present regime, its best arm and that arm's probability; undefined if the session is in no known regime. */
export function presentBest({ activity }: Pick<ScenePosterior, 'activity'>): { number: number; arm: string; probability: number } | undefined {
  const place = activity?.regimes.findIndex(({ isPresent, bestArm }) => isPresent && bestArm !== '') ?? -1;
  const present = activity?.regimes[place];
  const probability = present && bestOf(present, activity!)?.bestProbability;
  return probability === undefined ? undefined : { number: place + 1, arm: present!.bestArm, probability };
}

/** Returns whether regimes have different best arms, so that no single arm is the best. */
export const bestDiffer = (posterior: Judged) => regimeArms(posterior).length > 1;

/** Returns whether no single arm is the best, also because a session switches often. The daemon decides while a session is connected. */
export const isChanging = (posterior: Judged) => posterior.activity?.isChanging ?? bestDiffer(posterior);

/** Returns the arms that are the best: the leader of all evidence or, if the scene is changing, the best arm of each regime. */
export const leadersOf = (posterior: ScenePosterior): string[] =>
  (bestDiffer(posterior) ? regimeArms(posterior) : [posterior.leaderArm].filter(Boolean));

/** Returns the lowest P(best) of the regimes' best arms; 0 without regimes. */
export const surenessOf = (activity: SceneActivity) =>
  (activity.regimes.length === 0 ? 0 : Math.min(...activity.regimes.map((regime) => bestOf(regime, activity)?.bestProbability ?? 0)));

/** Describes a regime by what was measured of its scene. */
export function regimeText({ objectCount, speedMean, staticRatio }: RegimePosterior): string {
  const parts = [
    objectCount !== undefined && `${grouped(objectCount)} objects`,
    staticRatio !== undefined && `${share(staticRatio)} static`,
    speedMean !== undefined && `speed ${significant(speedMean, 2)} units/frame`,
  ];
  return parts.filter(Boolean).join(', ') || 'not described';
}

const microseconds = (us: number) => `${significant(us)} µs`;

/** Returns the cost with its interval; undefined if it is not known. */
export const costText = (arm: RegimeArm | undefined) =>
  (arm && arm.costUs > 0 ? `${microseconds(arm.costUs)} (${significant(arm.lowUs)} to ${significant(arm.highUs)})` : undefined);

/** Returns a saving per frame with its share of the frame time, as a text. */
export const savingWithShare = (us: number, ratio: number) => `${savingText(us)} (${signedShare(ratio)})`;

/** Returns a saving per frame, with a sign if it is negative. */
export const savingText = (us: number | undefined) => (us === undefined ? undefined : `${us < 0 ? '−' : ''}${microseconds(Math.abs(us))}`);
