// The table of a scene's arms, with the figures of the chart of posteriors.
import { significant } from '../../../format';
import { MEASURED_WORDS } from '../../charts/ridgeline';
import { mean } from '../../numbers/beta';
import { costNsOf, LOG_COST_REWARD_VERSION, rewardText } from '../../numbers/log_cost';
import { Arm } from '../../parts/arm';
import { ago, now } from '../../parts/clock';
import { type Column, Table } from '../../parts/table';
import type { ArmRow } from './model';

const count = (value: number) => value.toLocaleString('en');

function columns(rewardVersion: number): readonly Column<ArmRow>[] {
  const tellsCosts = rewardVersion === LOG_COST_REWARD_VERSION;
  const shown = (reward: number) => rewardText(reward, tellsCosts);
  const value = (reward: number) => (tellsCosts ? costNsOf(reward) : reward);
  const end = (row: ArmRow, high: boolean) => row.reward95[high === tellsCosts ? 0 : 1];
  const unit = tellsCosts ? ', in nanoseconds' : '';
  return [
    { id: 'arm', title: 'Arm', sort: ({ label }) => label,
      cell: (row) => <><Arm name={row.arm} hollow={row.measured !== 'live'} />{row.label !== row.arm && <span class="soft"> v{row.backendVersion}{row.isOld && ', old'}</span>}</> },
    { id: 'measured', title: 'Measured', isText: true, hint: 'Whether the arm ran in a game, or only in the shadow lane', sort: ({ measured }) => measured,
      cell: ({ measured }) => (measured === 'live' ? 'live' : <span class="lane-only" title={MEASURED_WORDS[measured]}>{measured === 'lane' ? 'lane only' : 'never'}</span>) },
    { id: 'best', title: 'P(best)', hint: 'Probability that the arm is the best', sort: ({ bestProbability }) => bestProbability, cell: ({ bestProbability }) => bestProbability?.toFixed(3) ?? '–' },
    { id: 'mean', title: tellsCosts ? 'Detection time' : 'Reward', hint: `Mean of the posterior${unit}`, sort: ({ posterior }) => value(mean(posterior)),
      cell: ({ posterior }) => shown(mean(posterior)) },
    { id: 'low', title: '95 % from', sort: (row) => value(end(row, false)), cell: (row) => shown(end(row, false)) },
    { id: 'high', title: 'to', sort: (row) => value(end(row, true)), cell: (row) => shown(end(row, true)) },
    ...(!tellsCosts ? [] : [{ id: 'ratio', title: 'Cost ÷ leader’s', hint: 'Cost relative to the leader: median, and 95 % credible interval', sort: ({ costRatio }: ArmRow) => costRatio?.median,
      cell: ({ costRatio: ratio }: ArmRow) => (ratio ? `${significant(ratio.median)} (${significant(ratio.low)} to ${significant(ratio.high)})` : '–') }]),
    { id: 'windows', title: 'Windows', hint: 'Decision windows in which the arm ran in games', sort: ({ windowCount }) => windowCount, cell: ({ windowCount }) => count(windowCount) },
    { id: 'visits', title: 'Lane visits', hint: 'Measurements of the arm in the shadow lane', sort: ({ visitCount }) => visitCount, cell: ({ visitCount }) => count(visitCount) },
    { id: 'n', title: 'Equivalent windows', hint: 'The number of live windows that would be as informative as all windows and lane visits together', sort: ({ effectiveWindowCount }) => effectiveWindowCount,
      cell: ({ effectiveWindowCount }) => (effectiveWindowCount > 0 ? significant(effectiveWindowCount) : '–') },
    { id: 'age', title: 'Changed', hint: 'Time of the latest evidence of the arm', sort: ({ changedMs }) => changedMs,
      cell: ({ changedMs }) => (changedMs === undefined ? <span class="soft">unknown</span> : ago(changedMs, now.value)) },
    { id: 'bails', title: 'Bail-outs', hint: 'Frames over the bail-out limit that the arm caused', sort: ({ bailOutCount }) => bailOutCount, cell: ({ bailOutCount }) => count(bailOutCount) },
    { id: 'alpha', title: 'α', sort: ({ posterior }) => posterior.alpha, cell: ({ posterior }) => significant(posterior.alpha, 5) },
    { id: 'beta', title: 'β', sort: ({ posterior }) => posterior.beta, cell: ({ posterior }) => significant(posterior.beta, 5) },
  ];
}

export const ArmTable = ({ rows, rewardVersion }: { rows: readonly ArmRow[]; rewardVersion: number }) =>
  <Table caption="Arms" columns={columns(rewardVersion)} rows={rows} keyOf={({ key }) => key} sort="-best" sortParameter="arms" />;
