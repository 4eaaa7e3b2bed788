// Compares two scenes, classes of machines or sessions side by side, on the same axes.
import { useComputed } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { share } from '../../format';
import { armsOf, MAX_STEPS, type Step } from '../audit/steps';
import { LogState, toldIn, useSessionLog, useSteps } from '../audit/use_log';
import { ChartFrame } from '../charts/frame';
import { RidgeFigure, ridgeRange, type RidgeRow } from '../charts/ridgeline';
import { TimelineChart } from '../charts/timeline';
import { TimeTools } from '../charts/time_chart';
import { range, type Range, useFrozen } from '../charts/view_state';
import { Arms } from '../parts/arm';
import { VerdictChip } from '../parts/chips';
import { sessionCsvUrl } from '../parts/download';
import { Select } from '../parts/filter';
import { CopyLink } from '../parts/toast';
import { Name, visible } from '../parts/name';
import { Empty } from '../parts/states';
import { navigate, sceneHref, sessionHref, setQuery } from '../state/route';
import type { SessionInfo } from '../../gen/sweepstake/v1/sessions_pb';
import { isChanging, leadersOf } from '../state/regimes';
import { leaderProbabilityOf, scenes, type SceneState } from '../state/scenes';
import { sessions } from '../state/sessions';
import { verdictOf } from '../state/summaries';
import { armRows, ridgeRows } from './scene/arms';
import { HistoryKind } from '../../gen/sweepstake/v1/history_pb';
import { selectionOf } from '../transport/history';
import { OverTime } from './over_time';
import { CostCharts, type Ends } from './session/cost_charts';
import { costColumns, stepQuery, switchMoments } from './session/model';

const Alone = () => <button type="button" class="quiet" onClick={() => setQuery({ with: undefined }, { step: true })}>Show only the first one</button>;
const span = (ranges: readonly (readonly [number, number])[]): [number, number] => [Math.min(...ranges.map(([low]) => low)), Math.max(...ranges.map(([, high]) => high))];

interface Side { state: SceneState; ridges: RidgeRow[] }

const sideOf = (state: SceneState): Side => ({ state, ridges: ridgeRows(armRows(state.posterior)) });

// Puts `rows` into the order of `first`, so that rows of the same arm are side by side.
const inOrderOf = (first: readonly RidgeRow[], rows: readonly RidgeRow[]): RidgeRow[] => {
  const places = new Map(first.map(({ label }, i) => [label, i]));
  const place = ({ label }: RidgeRow) => places.get(label) ?? first.length;
  return [...rows].sort((a, b) => place(a) - place(b));
};

function SceneSide({ side: { state, ridges }, rewards }: { side: Side; rewards: readonly [number, number] }) {
  const { posterior } = state;
  const leaders = leadersOf(posterior);
  const names = [posterior.project, posterior.scene, posterior.machineClass];
  return (
    <div>
      <h2><a href={sceneHref(posterior)}><Name text={posterior.scene} /></a> on <Name text={posterior.machineClass} /></h2>
      <p><VerdictChip verdict={verdictOf(state)} /> {leaders.length > 0 && <><Arms names={leaders} />, P(best) {leaderProbabilityOf(posterior).toFixed(3)}{!isChanging(posterior) && `, loss ${share(posterior.expectedLossRatio)}`}</>}</p>
      <RidgeFigure id="beliefs" title="Posterior of each algorithm" names={names} rows={ridges} rewardVersion={posterior.rewardVersion} rewards={rewards}
        notYet="No algorithm has evidence yet." />
      <OverTime selection={selectionOf(HistoryKind.SCENE, posterior)} names={names} />
    </div>
  );
}

export function CompareScenes({ own, other }: { own: SceneState; other: string }) {
  const beside = useComputed(() => scenes.value.get(other)).value;
  const states = useFrozen([own, ...(beside ? [beside] : [])], beside !== undefined);
  const sides = useMemo(() => states.map(sideOf).map((side, _, all) => ({ ...side, ridges: inOrderOf(all[0]!.ridges, side.ridges) })), [states.map((state) => state.posterior).length, ...states.map(({ posterior }) => posterior)]);
  if (!beside) return <Empty title="The daemon does not know the other scene"><p><Alone /></p></Empty>;
  const rewardVersion = own.posterior.rewardVersion;
  const hasOneReward = beside.posterior.rewardVersion === rewardVersion;
  const rewards = (side: Side) => (hasOneReward ? span(sides.map(({ ridges }) => ridgeRange(ridges))) : ridgeRange(side.ridges));
  return (
    <>
      <header class="title"><h1>Comparison</h1><span><Alone /><CopyLink /></span></header>
      {!hasOneReward && <p class="soft">The two scenes use different versions of the reward, which cannot be compared. Each has its own axes.</p>}
      <TimeTools />
      <div class="beside">
        {sides.map((side) => <SceneSide key={side.state.key} side={side} rewards={rewards(side)} />)}
      </div>
    </>
  );
}

type SessionData = ReturnType<typeof useSession>;

function useSession(id: string) {
  const state = useComputed(() => sessions.value.get(id)).value;
  const log = useSessionLog(id, toldIn(state), MAX_STEPS);
  const { steps, hasLog } = useSteps(log, state?.decisions, log.steps.at(-1)?.told?.rewardVersion ?? 0);
  const drawn = useMemo(() => ({ steps, arms: armsOf(steps), columns: costColumns(steps) }), [steps]);
  return useFrozen({ id, log, ...drawn, laterMs: 0 }, hasLog); // laterMs: real time minus drawn time
}

function endsOf(columns: readonly (readonly (number | null)[])[]): [number, number] {
  const values = columns.flat().filter((value): value is number => value !== null && value > 0);
  return [Math.min(...values), Math.max(0, ...values)];
}

// Returns when the session began. If the page has only the end of a long log, returns the time of the first step that it has.
const startOf = ({ steps }: SessionData, otherwiseMs: number) =>
  Number(steps.find(({ placed }) => placed?.setup)?.placed?.setup?.unixStartMs ?? 0) || (steps[0]?.timeMs ?? otherwiseMs);

// Shifts the times of a session so that it begins at `startMs`, the start of the session that it is compared with.
const laidTo = (startMs: number, data: SessionData): SessionData => {
  const laterMs = startOf(data, startMs) - startMs;
  const steps = data.steps.map((step) => ({ ...step, timeMs: step.timeMs - laterMs }));
  return { ...data, steps, columns: costColumns(steps), laterMs };
};

function SessionSide({ data: { id, log, steps, arms, columns, laterMs }, domain, ends }: { data: SessionData; domain: Range; ends: Ends }) {
  const moments = useMemo(() => switchMoments(steps, arms), [steps]);
  const openOwn = ({ decisionId, timeMs }: Step) => navigate(`${sessionHref(id)}?${new URLSearchParams(stepQuery({ decisionId, timeMs: timeMs + laterMs }))}`);
  return (
    <div>
      <h2>Session <a href={sessionHref(id)}><Name text={id} /></a></h2>
      <LogState log={log} />
      <ChartFrame id="timeline" title="Switches" names={[id]} csvHref={sessionCsvUrl('decisions', id)} empty={steps.length === 0 && 'The log of this session is empty.'}
        table={() => ({ header: ['time', 'active algorithm', 'candidate'], rows: steps.flatMap(({ timeMs, told }) => (told ? [[new Date(timeMs + laterMs).toISOString(), told.activeArm, told.candidate]] : [])) })}>
        <TimelineChart steps={steps} arms={arms} domain={domain} onOpen={openOwn} />
      </ChartFrame>
      <CostCharts columns={columns} moments={moments} domain={domain} names={[id]} ends={ends} laterMs={laterMs} csvHref={sessionCsvUrl('windows', id)} />
    </div>
  );
}

export function CompareWith({ info }: { info: SessionInfo }) {
  const others = [...sessions.value].filter(([id, { info: { project, scene } }]) => id !== info.sessionId && project === info.project && scene === info.scene)
    .map(([id]) => id);
  if (others.length === 0) return null;
  const options = [['', 'no other session'] as const, ...others.map((id) => [id, visible(id)] as const)];
  return <Select label="Compare with" value="" options={options} onChange={(id) => setQuery({ with: id, from: undefined, to: undefined }, { step: true })} />;
}

export function CompareSessions({ ids: [first, second] }: { ids: readonly [string, string] }) {
  const [own, other] = [useSession(first), useSession(second)];
  const startMs = startOf(own, 0);
  const laid = useMemo(() => laidTo(startMs, other), [startMs, other.steps]);
  const both = [own, { ...laid, log: other.log }];
  const lengthMs = Math.max(1000, ...both.map(({ steps }) => (steps.at(-1)?.timeMs ?? startMs) - startMs));
  const ends = { frameMs: endsOf(both.flatMap(({ columns }) => columns.frame)), detectionUs: endsOf(both.flatMap(({ columns }) => columns.detection)) };
  return (
    <>
      <header class="title"><h1>Comparison</h1><span><Alone /><CopyLink /></span></header>
      <TimeTools />
      <p class="soft">Both sessions are drawn as if they had begun at the same time. The axes show the times of the first session.</p>
      <div class="beside">{both.map((data) => <SessionSide key={data.id} data={data} domain={range.value ?? { fromMs: startMs, toMs: startMs + lengthMs }} ends={ends} />)}</div>
    </>
  );
}
