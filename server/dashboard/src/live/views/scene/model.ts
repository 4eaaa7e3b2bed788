// The rows of a scene's view, one per arm and backend version, from the daemon's message.
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
  label: string; // the arm, with its backend version if there are several
  backendVersion: number;
  isOld: boolean; // there is a newer version; decisions ignore this one
  posterior: Beta;
  measured: Measured;
  reward95: Interval;
  bestProbability: number | undefined; // undefined without evidence, and for old versions
  costRatio: Ratio | undefined; // cost ÷ the leader's cost; also undefined if rewards do not stand for costs
  windowCount: number;
  visitCount: number;
  bailOutCount: number;
  effectiveWindowCount: number; // number of live windows with the same information as all evidence; 0: unknown
  changedMs: number | undefined; // time of the latest evidence, by the daemon's clock; undefined: unknown
}

/** An arm is measured live if it has windows or bail-outs; then it ran in a game. */
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

/** Orders arms by P(best), highest first, old versions last. A posterior in `before` that differs is drawn behind the current one. */
export function ridgeRows(rows: readonly ArmRow[], before?: ScenePosterior): RidgeRow[] {
  const rank = ({ isOld, bestProbability }: ArmRow) => (isOld ? -1 : bestProbability ?? 0);
  return [...rows].sort((a, b) => rank(b) - rank(a) || a.key.localeCompare(b.key))
    .map(({ arm, label, backendVersion, posterior, reward95, measured }) => {
      const was = before?.arms.find((each) => each.arm === arm && each.backendVersion === backendVersion)?.posterior;
      const isOther = was && (was.alpha !== posterior.alpha || was.beta !== posterior.beta);
      return { arm, label, posterior, reward95, measured, ...(isOther && { before: was }) };
    });
}

/** Returns the names of the scene's arms, each once, in the daemon's order. */
export const armNames = (rows: readonly ArmRow[]) => rows.filter(({ isOld }) => !isOld).map(({ arm }) => arm);

/** Maximum number of switches that charts mark; more lines would hide the chart. */
export const MAX_SWITCHES = 40;

/** Returns the latest switch commands of a scene's sessions as marks of charts, oldest first. */
export const latestSwitches = (decisions: readonly DecisionEvent[]): Moment[] =>
  decisions.filter(({ outcome }) => outcome === DecisionOutcome.SWITCHED).slice(-MAX_SWITCHES)
    .map(({ unixMs, candidateArm }) => ({ timeMs: Number(unixMs), colour: colourOf(candidateArm) }));
