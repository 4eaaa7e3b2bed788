// The arms of a scene, one row per arm and backend version, from the daemon's message: the table, and the rows of charts.
import { significant } from '../../../format';
import { type ArmPosterior, type DecisionEvent, DecisionOutcome, type RewardPosterior, type ScenePosterior } from '../../../gen/sweepstake/v1/posteriors_pb';
import { colourOf } from '../../../palette';
import { useMemo } from 'preact/hooks';
import type { Moment } from '../../charts/plot';
import { type Measured, MEASURED_WORDS, type RidgeRow } from '../../charts/ridgeline';
import { mean } from '../../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, type Ratio, rewardText } from '../../numbers/log_cost';
import { Arm } from '../../parts/arm';
import { ago, now } from '../../parts/clock';
import { type Column, Table } from '../../parts/table';
import { lastSeenMs } from '../../state/scenes';

/** `label` is the arm's name, followed by the backend version if the scene has several versions of this arm. */
export type ArmRow = Omit<ArmPosterior, 'posterior'> & { key: string; label: string; measured: Measured; posterior: RewardPosterior };

/** Returns how an arm was measured. An arm with windows or bail-outs ran in a game, so it counts as 'live'. */
function measuredBy({ windowCount, visitCount, bailOutCount }: ArmPosterior): Measured {
  if (windowCount > 0n || bailOutCount > 0n) return 'live';
  return visitCount > 0n ? 'lane' : 'never';
}

export const armRows = ({ arms }: ScenePosterior): ArmRow[] => arms.flatMap((row) => {
  const { arm, backendVersion, posterior } = row;
  const hasVersions = arms.some((other) => other.arm === arm && other !== row);
  return posterior ? [{ ...row, posterior, key: `${arm}\n${backendVersion}`, label: hasVersions ? `${arm} v${backendVersion}` : arm, measured: measuredBy(row) }] : [];
});

/** Orders arms by their mean reward, the cheapest first, old versions last. A posterior in `before` that differs is drawn behind the current one. */
export function ridgeRows(rows: readonly ArmRow[], before?: ScenePosterior): RidgeRow[] {
  const rank = ({ isOutdated, posterior }: ArmRow) => (isOutdated ? -1 : mean(posterior));
  return [...rows].sort((a, b) => rank(b) - rank(a) || a.key.localeCompare(b.key))
    .map(({ arm, label, backendVersion, posterior, measured }) => {
      const was = before?.arms.find((each) => each.arm === arm && each.backendVersion === backendVersion)?.posterior;
      const isOther = was && (was.alpha !== posterior.alpha || was.beta !== posterior.beta);
      return { arm, label, posterior, measured, ...(isOther && { before: was }) };
    });
}

/** Maximum number of switches that charts mark; more lines would hide the chart. */
export const MAX_SWITCHES = 40;

export const latestSwitches = (decisions: readonly DecisionEvent[]): Moment[] =>
  decisions.filter(({ outcome }) => outcome === DecisionOutcome.SWITCHED).slice(-MAX_SWITCHES)
    .map(({ unixMs, candidateArm }) => ({ timeMs: Number(unixMs), colour: colourOf(candidateArm) }));

const ratioText = ({ median, low, high }: Ratio) => `${significant(median)} (${significant(low)} to ${significant(high)})`;

function columns(rewardVersion: number): readonly Column<ArmRow>[] {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const shown = (reward: number) => rewardText(reward, tellsCosts);
  const value = (reward: number) => (tellsCosts ? costNsOf(reward) : reward);
  const end = ({ posterior: { low95, high95 } }: ArmRow, isHigh: boolean) => (isHigh === tellsCosts ? low95 : high95);
  const ratio: Column<ArmRow> = { id: 'ratio', title: 'Cost ÷ leader’s', hint: 'Cost relative to the leader: median, and 95 % credible interval',
    sort: ({ costRatio }) => costRatio?.median, cell: ({ costRatio }) => (costRatio ? ratioText(costRatio) : '–') };
  return [
    { id: 'arm', title: 'Algorithm', sort: ({ label }) => label,
      cell: (row) => <><Arm name={row.arm} hollow={row.measured !== 'live'} />{row.label !== row.arm && <span class="soft"> v{row.backendVersion}{row.isOutdated && ', old'}</span>}</> },
    { id: 'measured', title: 'Measured', isText: true, hint: 'Whether the algorithm ran in a game, or only in the shadow lane', sort: ({ measured }) => measured,
      cell: ({ measured }) => (measured === 'live' ? 'live' : <span class="lane-only" title={MEASURED_WORDS[measured]}>{measured === 'lane' ? 'lane only' : 'never'}</span>) },
    { id: 'best', title: 'P(best)', hint: 'Probability that the algorithm is the best', sort: ({ bestProbability }) => bestProbability, cell: ({ bestProbability }) => bestProbability?.toFixed(3) ?? '–' },
    { id: 'mean', title: tellsCosts ? 'Detection time' : 'Reward', hint: 'Mean of the posterior',
      sort: ({ posterior }) => value(mean(posterior)), cell: ({ posterior }) => shown(mean(posterior)) },
    { id: 'low', title: '95 % from', sort: (row) => value(end(row, false)), cell: (row) => shown(end(row, false)) },
    { id: 'high', title: 'to', sort: (row) => value(end(row, true)), cell: (row) => shown(end(row, true)) },
    ...(tellsCosts ? [ratio] : []),
    { id: 'windows', title: 'Windows', hint: 'Decision windows in which the algorithm ran in games', sort: ({ windowCount }) => Number(windowCount) },
    { id: 'visits', title: 'Shadow measurements', hint: 'Visits of the shadow lane, which measures algorithms that do not run in the game', sort: ({ visitCount }) => Number(visitCount) },
    { id: 'n', title: 'Equivalent windows', isDetail: true, hint: 'The number of live windows that would be as informative as all windows and lane visits together', sort: ({ effectiveWindowCount }) => effectiveWindowCount,
      cell: ({ effectiveWindowCount }) => (effectiveWindowCount > 0 ? significant(effectiveWindowCount) : '–') },
    { id: 'age', title: 'Changed', hint: 'Time of the latest evidence of the algorithm', sort: (row) => lastSeenMs(row) || undefined,
      cell: (row) => (lastSeenMs(row) ? ago(lastSeenMs(row), now.value) : <span class="soft">unknown</span>) },
    { id: 'bails', title: 'Bail-outs', hint: 'Frames over the bail-out limit that the algorithm caused', sort: ({ bailOutCount }) => Number(bailOutCount) },
    { id: 'alpha', title: 'α', isDetail: true, hint: 'The first parameter of the reward’s Beta distribution: its mean is α ÷ (α + β), and it is narrower the larger α + β is', sort: ({ posterior }) => posterior.alpha, cell: ({ posterior }) => significant(posterior.alpha, 5) },
    { id: 'beta', title: 'β', isDetail: true, hint: 'The second parameter of the reward’s Beta distribution', sort: ({ posterior }) => posterior.beta, cell: ({ posterior }) => significant(posterior.beta, 5) },
  ];
}

export function ArmTable({ rows, rewardVersion, csvHref }: { rows: readonly ArmRow[]; rewardVersion: number; csvHref: string }) {
  const all = useMemo(() => columns(rewardVersion), [rewardVersion]);
  return <Table caption="Algorithms" csvHref={csvHref} columns={all} rows={rows} keyOf={({ key }) => key} sort="-best" sortParameter="arms" />;
}
