// The columns of the overview's list of scenes. The first ones read like a sentence: what runs, how fast the game is, what was saved.
import { grouped, share, signedShare, significant } from '../../../format';
import { FRAME_MS } from '../../numbers/log_cost';
import { Arm, Arms } from '../../parts/arm';
import { VerdictChip } from '../../parts/chips';
import { ago, duration, now } from '../../parts/clock';
import { Name } from '../../parts/name';
import { Sparkline } from '../../parts/sparkline';
import type { Column } from '../../parts/table';
import { bestDiffer, leadersOf, presentBest, savingText } from '../../state/regimes';
import { sceneHref } from '../../state/route';
import { frameTimesOf, sessions } from '../../state/sessions';
import type { SceneSummary } from '../../state/summaries';

const sceneOf = ({ state }: SceneSummary) => state.posterior;
const activityOf = (row: SceneSummary) => sceneOf(row).activity;
const savedUs = (row: SceneSummary) => activityOf(row)?.total?.savedAgainstInitialUs;
const hasLeader = (row: SceneSummary) => leadersOf(sceneOf(row)).length > 0;
// In a changing scene, the best algorithm of the present regime is meant.
const presentOf = (row: SceneSummary) => (bestDiffer(sceneOf(row)) ? presentBest(sceneOf(row)) : undefined);
const sureness = (row: SceneSummary) => (bestDiffer(sceneOf(row)) ? presentOf(row)?.probability : hasLeader(row) ? row.leaderProbability : undefined);
// In a changing scene no single algorithm is the choice, so there is no loss of choosing it.
const lossOf = (row: SceneSummary) => (hasLeader(row) && row.verdict !== 'changing' ? sceneOf(row).expectedLossRatio : undefined);

/** The session that `activity` is about. */
const sessionOf = (row: SceneSummary) => sessions.value.get(activityOf(row)?.sessionId ?? '');
const frameMs = (row: SceneSummary) => frameTimesOf(sessionOf(row)).at(-1);

function RunsNow({ row }: { row: SceneSummary }) {
  const activity = activityOf(row);
  if (!activity) return <>–</>;
  const { activeArm, unixActiveSinceMs, recentSwitchCount } = activity;
  return (
    <>
      <Arm name={activeArm} /> <span class="soft small">{duration(Math.max(0, now.value - Number(unixActiveSinceMs)))}
        {recentSwitchCount > 0 && `, ${grouped(recentSwitchCount)} /min`}</span>
    </>
  );
}

function Best({ row }: { row: SceneSummary }) {
  const [all, present] = [leadersOf(sceneOf(row)), presentOf(row)];
  if (!present) return <Arms names={all} />;
  return <><Arm name={present.arm} /> <span class="soft small">in regime {present.number} (now), {all.filter((arm) => arm !== present.arm).map((arm, i) => <span key={arm}>{i > 0 && ', '}<Name text={arm} /></span>)}</span></>;
}

function Sureness({ probability }: { probability: number | undefined }) {
  if (probability === undefined) return <>–</>;
  return <span class="sure"><span class="bar" aria-hidden="true"><span style={{ width: `${100 * probability}%` }} /></span>{probability.toFixed(3)}</span>;
}

function FrameTime({ row }: { row: SceneSummary }) {
  const times = frameTimesOf(sessionOf(row));
  const last = times.at(-1);
  if (last === undefined) return <>–</>;
  return <span class="curve-cell"><Sparkline values={times} low={0} high={Math.max(1.25 * FRAME_MS, ...times)} mark={FRAME_MS} />{significant(last)} ms</span>;
}

function Saved({ row }: { row: SceneSummary }) {
  const us = savedUs(row);
  const [text, frame] = [savingText(us), frameMs(row)];
  if (us === undefined || text === undefined) return <>–</>;
  return <span class={us > 0 ? 'gain' : undefined}>{text}{frame !== undefined && <span class="soft small"> {signedShare(us / 1000 / frame)}</span>}</span>;
}

export const SCENE_COLUMNS: readonly Column<SceneSummary>[] = [
  { id: 'scene', title: 'Scene', sort: (row) => `${sceneOf(row).project}\n${sceneOf(row).scene}`,
    cell: (row) => <a href={sceneHref(sceneOf(row))}><Name text={sceneOf(row).scene} /></a> },
  { id: 'runs', title: 'Runs now', isText: true, width: '10rem', hint: 'The algorithm that runs now in the session that has been connected the longest, for how long, and its switches per minute',
    sort: (row) => activityOf(row)?.activeArm, cell: (row) => <RunsNow row={row} /> },
  { id: 'frame', title: 'Frame time', width: '10rem', hint: 'Median frame time of this session since the page was opened. The dotted line is 16.7 ms, 60 frames per second.',
    sort: frameMs, cell: (row) => <FrameTime row={row} /> },
  { id: 'saved', title: 'Saved per frame', width: '8.5rem', hint: 'Detection time per frame that this session saved against the algorithm that its game begins with, and its share of the frame time',
    sort: savedUs, cell: (row) => <Saved row={row} /> },
  { id: 'leader', title: 'Best', isText: true, width: '8rem', hint: 'The algorithm with the highest probability of being the best; in a changing scene, the best of the present regime and those of the others',
    sort: (row) => leadersOf(sceneOf(row)).join(' '), cell: (row) => <Best row={row} /> },
  { id: 'p', title: 'P(best)', width: '7rem', hint: 'Probability that this algorithm is the best; in a changing scene, in the present regime', sort: sureness,
    cell: (row) => <Sureness probability={sureness(row)} /> },
  { id: 'verdict', title: 'Verdict', isText: true, width: '8rem', hint: 'Says whether the best algorithm is known. This column sorts by uncertainty.', sort: (row) => row.uncertainty,
    cell: (row) => <VerdictChip verdict={row.verdict} /> },
  { id: 'sessions', title: 'Sessions', hint: 'Sessions connected now', sort: (row) => sceneOf(row).activeSessionCount },
  { id: 'class', title: 'Machines', isText: true, hint: 'Class of machines', sort: (row) => sceneOf(row).machineClass },
  { id: 'project', title: 'Project', isText: true, sort: (row) => sceneOf(row).project },
  { id: 'loss', title: 'Loss', width: '6rem', isDetail: true, hint: 'Expected extra cost of choosing this algorithm instead of the best one', sort: lossOf,
    cell: (row) => { const loss = lossOf(row); return loss === undefined ? '–' : share(loss); } },
  { id: 'evidence', title: 'Measurements', width: '7rem', isDetail: true, hint: 'Windows and visits of the shadow lane in all sessions', sort: (row) => Number(row.evidence) },
  { id: 'changed', title: 'Changed', width: '7rem', isDetail: true, hint: 'Time of the last change that this page received. If there was none: time of the latest evidence',
    sort: (row) => row.state.changedMs || undefined, cell: (row) => (row.state.changedMs ? ago(row.state.changedMs, now.value) : '–') },
  { id: 'reward', title: 'Reward', isDetail: true, hint: 'Version of the formula that turns a cost into a reward; AI Decides uses version 3', sort: (row) => sceneOf(row).rewardVersion },
];
