// The rows of a scene's view, one per arm, from what the daemon sent.
import { type ArmPosterior, type DecisionEvent, DecisionOutcome, type ScenePosterior } from '../../../gen/sweepstake/v1/posteriors_pb';
import { colourOf } from '../../../palette';
import type { Moment } from '../../charts/plot';
import type { Measured, RidgeRow } from '../../charts/ridgeline';
import type { Beta, Interval } from '../../numbers/beta';
import type { Ratio } from '../../numbers/log_cost';
import { lastSeenMs, type SceneState } from '../../state/scenes';

export interface ArmRow {
  key: string;
  arm: string;
  label: string; // with the version of its backend where there are several
  backendVersion: number;
  isOld: boolean; // there is a newer version, and decisions do not depend on this one
  posterior: Beta;
  measured: Measured;
  reward95: Interval;
  bestProbability: number | undefined; // undefined: nothing is learnt, or there is a newer version
  costRatio: Ratio | undefined; // ÷ the leader's cost; undefined as well where rewards do not tell costs
  windowCount: number;
  visitCount: number;
  bailOutCount: number;
  effectiveWindowCount: number; // so many live windows would tell as much; 0: not known
  changedMs: number | undefined; // when something was learnt of it last, by the daemon's clock; undefined: not known
}

/** An arm without windows never ran in a game, whatever is believed of it. */
export function measuredBy({ windowCount, visitCount, bailOutCount }: Pick<ArmPosterior, 'windowCount' | 'visitCount' | 'bailOutCount'>): Measured {
  if (windowCount > 0n || bailOutCount > 0n) return 'live';
  return visitCount > 0n ? 'lane' : 'never';
}

export function armRows({ posterior: { arms } }: SceneState): ArmRow[] {
  return arms.flatMap((arm): ArmRow[] => {
    if (!arm.posterior) return [];
    const hasVersions = arms.some((other) => other.arm === arm.arm && other !== arm);
    return [{
      key: `${arm.arm}\n${arm.backendVersion}`,
      arm: arm.arm,
      label: hasVersions ? `${arm.arm} v${arm.backendVersion}` : arm.arm,
      backendVersion: arm.backendVersion,
      isOld: arm.isOutdated,
      posterior: arm.posterior,
      measured: measuredBy(arm),
      reward95: [arm.rewardLow95, arm.rewardHigh95],
      bestProbability: arm.bestProbability,
      costRatio: arm.costRatio,
      windowCount: Number(arm.windowCount),
      visitCount: Number(arm.visitCount),
      bailOutCount: Number(arm.bailOutCount),
      effectiveWindowCount: arm.effectiveWindowCount,
      changedMs: lastSeenMs(arm) || undefined,
    }];
  });
}

/** The most probable arm first, arms of old versions last. What was believed in `before` is drawn behind, where it was something else. */
export function ridgeRows(rows: readonly ArmRow[], before?: ScenePosterior): RidgeRow[] {
  const rank = ({ isOld, bestProbability }: ArmRow) => (isOld ? -1 : bestProbability ?? 0);
  return [...rows].sort((a, b) => rank(b) - rank(a) || a.key.localeCompare(b.key))
    .map(({ arm, label, backendVersion, posterior, reward95, measured }) => {
      const was = before?.arms.find((each) => each.arm === arm && each.backendVersion === backendVersion)?.posterior;
      const isOther = was && (was.alpha !== posterior.alpha || was.beta !== posterior.beta);
      return { arm, label, posterior, reward95, measured, ...(isOther && { before: was }) };
    });
}

/** The scene's arms, each once, in the order of the daemon. */
export const armNames = (rows: readonly ArmRow[]) => rows.filter(({ isOld }) => !isOld).map(({ arm }) => arm);

/** Many games switch in a scene; more lines than these would hide what they mark. */
export const MAX_SWITCHES = 40;

/** Returns the latest switches that its sessions were told to make, as charts mark them, oldest first. */
export const latestSwitches = (decisions: readonly DecisionEvent[]): Moment[] =>
  decisions.filter(({ outcome }) => outcome === DecisionOutcome.SWITCHED).slice(-MAX_SWITCHES)
    .map(({ unixMs, candidateArm }) => ({ timeMs: Number(unixMs), colour: colourOf(candidateArm) }));
