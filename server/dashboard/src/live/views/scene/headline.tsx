// The first sentences of a scene's view: what runs now, which arm is the best, in each regime if that differs, and what was saved.
import { counted, share, significant } from '../../../format';
import type { RegimePosterior, SceneActivity, ScenePosterior } from '../../../gen/sweepstake/v1/posteriors_pb';
import { Verdict } from '../../../gen/sweepstake/v1/telemetry_pb';
import { percentilesOf } from '../../audit/steps';
import { Arm, Arms } from '../../parts/arm';
import { VerdictChip } from '../../parts/chips';
import { duration, now, timeText } from '../../parts/clock';
import { REFERENCE_ARM } from '../../numbers/use';
import { Name, visible } from '../../parts/name';
import { type Column, Table } from '../../parts/table';
import { bestDiffer, bestOf, costText, regimeArms, regimeText, savingText } from '../../state/regimes';
import { sessionHref } from '../../state/route';
import { leaderProbabilityOf, type SceneState } from '../../state/scenes';
import { frameTimesOf, sessions } from '../../state/sessions';
import { type SceneVerdict, verdictOf } from '../../state/summaries';
import { verdictWord } from '../words';

function RunsNow({ activity, sessionCount }: { activity: SceneActivity; sessionCount: number }) {
  const sinceMs = Number(activity.unixActiveSinceMs);
  return (
    <p class="runs-now">
      <b><Arm name={activity.activeArm} /></b> runs now, for <b title={timeText(sinceMs)}>{duration(Math.max(0, now.value - sinceMs))}</b>, in session{' '}
      <a href={sessionHref(activity.sessionId)}>{activity.sessionId.slice(0, 8)}</a>
      {sessionCount > 1 && `, which has been connected the longest of ${sessionCount}`}. It has switched <b>{counted(activity.recentSwitchCount, 'time', 'times')}</b> in the last minute.
    </p>
  );
}

function partOf(state: SceneState): string {
  const last = state.decisions.findLast(({ verdict, measurements }) => verdict === Verdict.DEGRADED && measurements)?.measurements;
  const { detectionMs, frameMs } = last ? percentilesOf(last) : {};
  if (!detectionMs?.[0] || !frameMs?.[0]) return '';
  return `The broad phase takes ${share(detectionMs[0] / frameMs[0])} of the frame. `;
}

function OneBest({ state, verdict }: { state: SceneState; verdict: SceneVerdict }) {
  const { posterior } = state;
  if (!posterior.leaderArm) return <>{verdictWord(verdict).meaning}</>;
  return (
    <>
      {verdict === Verdict.DEGRADED && `${verdictWord(verdict).meaning} ${partOf(state)}`}{verdict === 'changing' && 'A session has switched more than four times in the last minute. Over all evidence, '}<b><Name text={posterior.leaderArm} /></b> is the best algorithm with a probability of{' '}
      <b class="leader-probability">{leaderProbabilityOf(posterior).toFixed(3)}</b>.{verdict !== 'changing' && <> Choosing it loses <b>{share(posterior.expectedLossRatio)}</b> on average. With
        exactly known costs, the choice would gain <b>{share(posterior.valueRemainingRatio)}</b> on average.</>}
    </>
  );
}

function BestOfRegimes({ posterior }: { posterior: ScenePosterior }) {
  const { activity } = posterior;
  if (!activity) return <>The best algorithm depended on the regime of the scene: <Arms names={regimeArms(posterior)} />.</>;
  return (
    <>
      The best algorithm depends on the regime of the scene:{' '}
      {activity.regimes.map((regime, i) => (
        <span key={i}>{i > 0 && ', '}<b><Name text={regime.bestArm} unknown="unknown" /></b> with a probability of{' '}
          <b>{bestOf(regime, activity)?.bestProbability.toFixed(3) ?? '–'}</b> in regime {i + 1}{regime.isPresent && ' (now)'}</span>
      ))}.
    </>
  );
}

function saved(us: number | undefined, frameMs: number | undefined, against: string): string | undefined {
  if (us === undefined) return undefined;
  const ratio = frameMs === undefined ? '' : ` (${share(Math.abs(us) / 1000 / frameMs)} of the frame time)`;
  return `${us < 0 ? 'loses' : 'saves'} ${savingText(Math.abs(us))}${ratio} per frame against ${against}`;
}

function Savings({ total, activity }: { total: RegimePosterior; activity: SceneActivity }) {
  const cost = costText(bestOf(total, activity));
  const { initialArm } = activity;
  const frameMs = frameTimesOf(sessions.value.get(activity.sessionId)).at(-1);
  const parts = [
    saved(total.savedAgainstInitialUs, frameMs, `${visible(initialArm)}, the algorithm that the game begins with`),
    initialArm !== total.bestArm && saved(total.savedAgainstSingleUs, frameMs, 'the best single choice'),
    initialArm !== REFERENCE_ARM && saved(total.savedAgainstReferenceUs, frameMs, REFERENCE_ARM),
  ].filter(Boolean);
  if (!total.bestArm || !cost) return null;
  return (
    <p class="savings">
      The best single choice is <b><Name text={total.bestArm} /></b> with {cost} per frame.{' '}
      {parts.length > 0 && <>This session <b>{parts.join('; it ')}</b>, including the cost of its switches.</>}
    </p>
  );
}

export function Headline({ state }: { state: SceneState }) {
  const { activity, activeSessionCount } = state.posterior;
  const verdict = verdictOf(state);
  return (
    <>
      {activity && <RunsNow activity={activity} sessionCount={activeSessionCount} />}
      <p>
        <VerdictChip verdict={verdict} />{' '}
        {bestDiffer(state.posterior) ? <BestOfRegimes posterior={state.posterior} /> : <OneBest state={state} verdict={verdict} />}
      </p>
      {activity?.total && <Savings total={activity.total} activity={activity} />}
    </>
  );
}

interface Row { name: string; regime: RegimePosterior; activity: SceneActivity }

const COLUMNS: readonly Column<Row>[] = [
  { id: 'regime', title: 'Regime', sort: ({ name }) => name },
  { id: 'scene', title: 'Scene', isText: true, hint: 'What is typical of the scene in this regime', sort: ({ regime, name }) => (name === 'all' ? undefined : regimeText(regime)),
    cell: ({ regime, name }) => (name === 'all' ? '–' : <bdi class="words">{regimeText(regime)}</bdi>) },
  { id: 'frames', title: 'Frames', hint: 'Share of the frames in this regime', sort: ({ regime }) => regime.frameShare, cell: ({ regime }) => share(regime.frameShare) },
  { id: 'best', title: 'Best algorithm', isText: true, sort: ({ regime }) => regime.bestArm, cell: ({ regime }) => <Arm name={regime.bestArm} /> },
  { id: 'p', title: 'P(best)', hint: 'Probability that this algorithm is the best in this regime', sort: ({ regime, activity }) => bestOf(regime, activity)?.bestProbability,
    cell: ({ regime, activity }) => bestOf(regime, activity)?.bestProbability.toFixed(3) ?? '–' },
  { id: 'cost', title: 'Its mean cost', hint: 'Mean detection time per frame: estimate, and 95 % credible interval', sort: ({ regime, activity }) => bestOf(regime, activity)?.costUs,
    cell: ({ regime, activity }) => costText(bestOf(regime, activity)) ?? '–' },
  { id: 'ran', title: 'Mean cost of what ran', hint: 'Mean detection time per frame of the algorithms that ran, with the cost of switches. These can make it higher than the cost of the best algorithm.', sort: ({ regime }) => regime.ranUs,
    cell: ({ regime }) => (regime.ranUs === undefined ? '–' : `${significant(regime.ranUs)} µs`) },
  { id: 'saved', title: 'Saved', hint: 'Saved per frame against the algorithm that the game begins with', sort: ({ regime }) => regime.savedAgainstInitialUs,
    cell: ({ regime }) => savingText(regime.savedAgainstInitialUs) ?? '–' },
  { id: 'saved-single', title: 'Saved, best single', hint: 'Saved per frame against the best single choice', sort: ({ regime }) => regime.savedAgainstSingleUs,
    cell: ({ regime }) => savingText(regime.savedAgainstSingleUs) ?? '–' },
  { id: 'saved-kdtree', title: 'Saved, KDTree', isDetail: true, hint: 'Saved per frame against KDTree', sort: ({ regime }) => regime.savedAgainstReferenceUs,
    cell: ({ regime }) => savingText(regime.savedAgainstReferenceUs) ?? '–' },
];

const rowsOf = (activity: SceneActivity): Row[] => [
  ...activity.regimes.map((regime, i) => ({ name: `${i + 1}${regime.isPresent ? ' (now)' : ''}`, regime, activity })),
  ...(activity.total ? [{ name: 'all', regime: activity.total, activity }] : []),
];

export function Regimes({ posterior: { activity } }: { posterior: ScenePosterior }) {
  if (!activity) return <p class="soft">No session is connected. Regimes are shown only during a session.</p>;
  if (activity.regimes.length === 0) return <p class="soft">The session has seen one regime so far: {activity.total ? regimeText(activity.total) : 'not described'}.</p>;
  return (
    <>
      <Table caption="Best algorithm of each regime" columns={COLUMNS} rows={rowsOf(activity)} keyOf={({ name }) => name.split(' ')[0]!} sort="regime" sortParameter="regimes" />
      <p class="soft">The cost of the best algorithm is an estimate; the cost of what ran is measured, with its switches. They differ the more, the wider the interval of the estimate is.</p>
    </>
  );
}
