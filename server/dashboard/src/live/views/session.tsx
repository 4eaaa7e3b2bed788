// The view of a session: which arm ran when and why, frame costs, posteriors, shadow lane, and an operator's orders.
import { useComputed } from '@preact/signals';
import { useEffect, useMemo, useRef } from 'preact/hooks';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { counted, grouped } from '../../format';
import { armsOf, isSwitch, readSteps, type Step, stepOfRow, stepsOf } from '../audit/steps';
import { readDecision, readRows } from '../audit/log';
import { LogState, type SessionLog, toldIn, useSessionLog, useSteps } from '../audit/use_log';
import { ChartFrame } from '../charts/frame';
import type { Moment } from '../charts/plot';
import { BestChart, MeansChart } from '../charts/posterior_charts';
import { RidgeFigure } from '../charts/ridgeline';
import { TimelineChart } from '../charts/timeline';
import { TimeTools } from '../charts/time_chart';
import { domainOf, range, type Range, useFrozen } from '../charts/view_state';
import { LOG_COST_REWARD_VERSION, nsText } from '../numbers/log_cost';
import { Arm } from '../parts/arm';
import { Chip } from '../parts/chips';
import { ago, now, timeText } from '../parts/clock';
import { sessionCsvUrl } from '../parts/download';
import { CopyLink } from '../parts/toast';
import { measuredIn, savingsOf } from '../numbers/use';
import { Name } from '../parts/name';
import { savingWithShare } from '../state/regimes';
import { useHistory, WHOLE_LIFE } from '../transport/history';
import { Empty, Failure, Later, Loading, Read } from '../parts/states';
import { type Column, Table } from '../parts/table';
import { account, isOperator } from '../state/account';
import type { SessionInfo } from '../../gen/sweepstake/v1/sessions_pb';
import { decisionsHref, route, sceneHref, setQuery } from '../state/route';
import { isConnected, lastMessageMs, sessionInView, sessions, type SessionState } from '../state/sessions';
import { urlOf } from '../transport/calls';
import { useReading } from '../transport/reading';
import { HistoryKind } from '../../gen/sweepstake/v1/history_pb';
import { OverTime } from './over_time';
import { CompareSessions, CompareWith } from './compare';
import { explained } from '../audit/explain';
import { CostCharts } from './session/cost_charts';
import { beliefRows, costColumns, laneSums, type LaneSum, decisiveStep, priorAndPosterior, executionOf, isLastSwitch, stepQuery, stepsIn, switchMoments } from './session/model';
import { Orders } from './session/orders';
import { Why } from './session/why';
import { endWord, modeWord, outcomeWord, stateWord } from './words';

const rewardVersionOf = (steps: readonly Step[], state: SessionState | undefined) =>
  (state?.decisions.at(-1) ?? steps.findLast(({ told }) => told)?.told)?.rewardVersion ?? LOG_COST_REWARD_VERSION;

function Facts({ sessionId, state, steps, rewardVersion }: { sessionId: string; state: SessionState | undefined; steps: readonly Step[]; rewardVersion: number }) {
  const setup = steps.findLast(({ placed }) => placed?.setup)?.placed?.setup;
  const info = state?.info;
  const { series } = useHistory({ kind: HistoryKind.SESSION, sessionId }, WHOLE_LIFE);
  const total = series[0]?.points[0] && measuredIn(series[0].points[0]);
  const names = { project: info?.project ?? setup?.project ?? '', scene: info?.scene ?? setup?.scene ?? '' };
  const machineClass = info?.machineClass ?? setup?.machineClass ?? '';
  const word = !state ? undefined : state.ended ? endWord(state.ended.end) : stateWord(state.info.state);
  return (
    <dl class="facts">
      <div><dt>Scene</dt><dd><a href={sceneHref({ ...names, machineClass, rewardVersion })}><Name text={names.scene} /></a></dd></div>
      <div><dt>Project</dt><dd><Name text={names.project} /></dd></div>
      {word && <div><dt>State</dt><dd><Chip tone={state && isConnected(state) ? 'good' : 'plain'} sign={word.mark} title={word.meaning}>{word.name}</Chip></dd></div>}
      {info && <div><dt>Mode</dt><dd title={modeWord(info.mode).meaning}>{modeWord(info.mode).name}</dd></div>}
      {info && <div><dt>Active algorithm</dt><dd><Arm name={info.activeArm} /></dd></div>}
      {info && <div><dt>Begins with</dt><dd title="The algorithm that the game begins with, and that it would keep without the daemon"><Arm name={info.initialArm} /></dd></div>}
      <div><dt>Machines</dt><dd><Name text={machineClass} /></dd></div>
      {info && <div><dt>Build</dt><dd><Name text={info.build} /></dd></div>}
      {info && <div><dt>Address</dt><dd><Name text={info.clientAddress} /></dd></div>}
      {info && <div><dt>Began</dt><dd>{timeText(Number(info.unixStartMs))}</dd></div>}
      {state && lastMessageMs(state) > 0 && <div><dt>Last message</dt><dd class="ago">{ago(lastMessageMs(state), now.value)}</dd></div>}
      {total && <div><dt>Saved per frame, and share of the frame time</dt><dd>{savingsOf(total).map(({ us, ratio, against }) => `${savingWithShare(us, ratio)} against ${against}`).join(', ') || '–'}</dd></div>}
      {info && <div><dt>Dropped frames</dt><dd>{String(info.droppedFrameCount)}</dd></div>}
    </dl>
  );
}

function AskedStep({ sessionId, onOpen }: { sessionId: string; onOpen(step: Step): void }) {
  const { query } = route.value;
  const [id, at] = [Number(query.get('decision') ?? 0), Number(query.get('at') ?? 0)];
  const reading = useReading(`${id} ${at}`, async (cancel) => {
    if (!(id > 0)) return (await readSteps(sessionId, at, at + 1, cancel))[0] ?? null;
    const placed = await readDecision(sessionId, BigInt(Math.floor(id)), cancel);
    return placed && stepOfRow(placed) || null;
  });
  const { value } = reading;
  useEffect(() => { if (value) onOpen(value); }, [value]);
  return <Read reading={reading} what="the decision">{(step) => (step ? null : <p class="soft" role="status">The log does not have the decision in the URL.</p>)}</Read>;
}

/** Returns the decision that explains the active arm. Reads it if it may be older than the steps of the view. */
async function decisiveOf(sessionId: string, steps: readonly Step[], isWhole: boolean): Promise<Step | undefined> {
  const found = decisiveStep(steps);
  if (!found || isWhole || isSwitch(found)) return found;
  const part = await readRows({ sessionId, outcomes: [DecisionOutcome.SWITCHED], arm: found.activeArm }, 10).catch(() => undefined);
  return (part && decisiveStep([...stepsOf(part), found])) ?? found;
}

const asksForStep = () => route.value.query.has('decision') || route.value.query.has('at');

/** Returns the step in the URL, and a function that opens a step. An opened step stays, even if the page drops it from its log. */
function useChosenStep(steps: readonly Step[]): [Step | undefined, (step: Step) => void] {
  const { query } = route.value;
  const [id, at] = [Number(query.get('decision') ?? 0), Number(query.get('at') ?? 0)];
  const isIt = ({ decisionId, timeMs, told }: Step) => (id > 0 ? decisionId === id && told !== undefined : at > 0 && Math.round(timeMs) === at);
  const last = useRef<Step | undefined>(undefined);
  const found = steps.find(isIt);
  if (found ?? (last.current && !isIt(last.current))) last.current = found;
  const open = (step: Step) => {
    last.current = step;
    setQuery({ decision: undefined, at: undefined, ...stepQuery(step) }, { step: true });
  };
  return [last.current, open];
}

const decisionTable = (steps: readonly Step[]) => ({
  header: ['time', 'decision', 'active algorithm', 'candidate', 'outcome', 'in words'],
  rows: steps.flatMap(({ timeMs, decisionId, told }) => (told
    ? [[new Date(timeMs).toISOString(), decisionId, told.activeArm, told.candidate, outcomeWord(told.outcome).name, explained(told)[0]]] : [])),
});

const LANE_COLUMNS: readonly Column<LaneSum>[] = [
  { id: 'arm', title: 'Algorithm', sort: ({ arm }) => arm, cell: ({ arm }) => <Arm name={arm} hollow /> },
  { id: 'visits', title: 'Visits', sort: ({ visitCount }) => visitCount },
  { id: 'median', title: 'Median', hint: 'Median detection time in the lane', sort: ({ medianNs }) => medianNs, cell: ({ medianNs }) => nsText(medianNs) },
  { id: 'last', title: 'Last', sort: ({ lastNs }) => lastNs, cell: ({ lastNs }) => nsText(lastNs) },
  { id: 'build', title: 'Build', hint: 'Median time to build the algorithm’s data structure', sort: ({ buildNs }) => buildNs, cell: ({ buildNs }) => nsText(buildNs) },
  { id: 'capped', title: 'Cut short', hint: 'Visits that the lane ended early, because they reached its time limit', sort: ({ cappedCount }) => cappedCount },
  { id: 'when', title: 'Last visit', sort: ({ lastMs }) => lastMs, cell: ({ lastMs }) => timeText(lastMs) },
];

function Lane({ steps }: { steps: readonly Step[] }) {
  const sums = useMemo(() => laneSums(steps), [steps]);
  if (sums.length === 0) return <p class="soft">The shadow lane has measured nothing in this session, or it is off.</p>;
  return <Table caption="Visits of the shadow lane" columns={LANE_COLUMNS} rows={sums} keyOf={({ arm }) => arm} sort="median" sortParameter="lane" />;
}

// `shown` are the steps in the chosen range of time. The charts draw them with a limited number of points, so a zoom refines them.
interface ChartsProps { sessionId: string; steps: readonly Step[]; shown: readonly Step[]; arms: readonly string[]; moments: readonly Moment[]; rewardVersion: number; domain: Range }

function Timeline({ sessionId, steps, arms, domain, onOpen }: ChartsProps & { onOpen(step: Step): void }) {
  const switchCount = steps.filter(isSwitch).length;
  return (
    <ChartFrame id="timeline" title="Switches" names={[sessionId]} table={() => decisionTable(steps)} csvHref={sessionCsvUrl('decisions', sessionId)} empty={steps.length === 0 && 'There are no decisions yet.'}
      note={`${counted(switchCount, 'switch command', 'switch commands')} in the rows that were read. Dotted lines in the charts below mark changes of the active algorithm.`}>
      <TimelineChart steps={steps} arms={arms} domain={domain} onOpen={onOpen} />
    </ChartFrame>
  );
}

function Beliefs({ sessionId, steps, shown, arms, moments, rewardVersion, domain }: ChartsProps) {
  const rows = useMemo(() => beliefRows(shown, arms.length), [shown, arms]);
  const ridges = useMemo(() => priorAndPosterior(steps, arms), [steps, arms]);
  const known = useMemo(() => rows.filter(({ beliefs }) => beliefs.some(Boolean)), [rows]);
  const assumed = useMemo(() => new Set(ridges.filter(({ measured }) => measured === 'never').map(({ arm }) => arm)), [ridges]);
  const common = { arms, moments, names: [sessionId], domain, notYet: 'The log has fewer than two decisions.', csvHref: sessionCsvUrl('posteriors', sessionId) };
  return (
    <>
      <BestChart {...common} rows={rows} />
      <MeansChart {...common} rows={known} rewardVersion={rewardVersion} assumed={assumed} />
      <RidgeFigure id="prior" title="Prior and posterior of this session" names={[sessionId]} rows={ridges} csvHref={common.csvHref} rewardVersion={rewardVersion}
        notYet="The log has no decision yet." note="Dashed grey: the prior that the session began with, if it had one." />
    </>
  );
}

// Returns why the user cannot view the boxes of the session; empty if it is possible.
function whyNoBoxes({ showsBoxes }: SessionInfo, isOver: boolean): string {
  if (isOver) return 'The session has ended.';
  if (!showsBoxes) return 'This game does not send its boxes: its setting allow_box_view is off.';
  return isOperator.value ? '' : `Viewing boxes needs the role operator; yours is ${account.value?.role ?? 'unknown'}.`;
}

function Boxes({ info, isOver }: { info: SessionInfo; isOver: boolean }) {
  const reason = whyNoBoxes(info, isOver);
  const isShown = route.value.query.has('boxes') && reason === '';
  return (
    <section aria-labelledby="boxes-heading">
      <h2 id="boxes-heading">Objects</h2>
      <p class="orders">
        <button type="button" disabled={reason !== ''} aria-pressed={isShown} onClick={() => setQuery({ boxes: isShown ? undefined : 'on' })}>Show boxes</button>
        <span class="soft">{reason || 'While this view is open, the game sends boxes of its objects: at most 64 kB, four times a second.'}</span>
        <a href={urlOf('/recording')}>Play a recording</a>
      </p>
      {isShown && <Later name="boxes" load={async () => (await import('./session/boxes')).SessionBoxes} props={{ sessionId: info.sessionId }} />}
    </section>
  );
}

function Session({ sessionId, state: latest, log }: { sessionId: string; state: SessionState | undefined; log: SessionLog }) {
  const state = useFrozen(latest, latest !== undefined);
  const rewardVersion = rewardVersionOf(log.steps, state);
  const known = useSteps(log, state?.decisions, rewardVersion);
  const { steps } = useFrozen(known, known.hasLog);
  const names = armsOf(steps);
  const arms = useMemo(() => names, [names.join('\n')]);
  const domain = domainOf(steps.map(({ timeMs }) => timeMs), range.value);
  const moments = useMemo(() => switchMoments(steps, arms), [steps, arms]);
  const shown = useMemo(() => stepsIn(range.value, steps), [steps, range.value]);
  const columns = useMemo(() => costColumns(shown), [shown]);
  const [chosen, openStep] = useChosenStep(steps);
  const openDecisive = () => void decisiveOf(sessionId, steps, log.isWhole).then((step) => step && openStep(step));
  const props = { sessionId, steps, shown, arms, moments, rewardVersion, domain };
  return (
    <>
      <header class="title"><h1>Session <Name text={sessionId} /></h1><CopyLink /></header>
      <Facts sessionId={sessionId} state={state} steps={steps} rewardVersion={rewardVersion} />
      {latest && <Orders info={latest.info} arms={arms} isOver={latest.ended !== undefined} />}
      <p class="orders">
        <button type="button" class="primary" disabled={log.isReading || !decisiveStep(steps)} onClick={openDecisive}>Why this algorithm?</button>
        <a href={decisionsHref({ session: sessionId })}>All rows of its log</a>
        {latest && <CompareWith info={latest.info} />}
        <span class="soft">{grouped(steps.findLast(({ told }) => told)?.decisionId ?? 0)} decisions</span>
      </p>
      <LogState log={log} />
      {chosen && <Why step={chosen} done={executionOf(chosen, steps)} isLast={isLastSwitch(chosen, steps)} sessionId={sessionId} onRead={log.again} onClose={() => setQuery({ decision: undefined, at: undefined })} />}
      {!chosen && !log.isReading && asksForStep() && <AskedStep sessionId={sessionId} onOpen={openStep} />}
      <TimeTools />
      <Timeline {...props} onOpen={openStep} />
      <section aria-labelledby="history-heading"><h2 id="history-heading">History</h2>
        <OverTime selection={{ kind: HistoryKind.SESSION, sessionId }} names={[sessionId]} moments={moments} /></section>
      <section aria-labelledby="windows-heading"><h2 id="windows-heading">Latest windows</h2>
        <CostCharts columns={columns} moments={moments} domain={domain} names={[sessionId]} csvHref={sessionCsvUrl('windows', sessionId)} /></section>
      {latest && <Boxes info={latest.info} isOver={latest.ended !== undefined} />}
      <section aria-labelledby="beliefs-heading"><h2 id="beliefs-heading">Posteriors</h2><Beliefs {...props} /></section>
      <section aria-labelledby="lane-heading"><h2 id="lane-heading">Shadow lane</h2><Lane steps={steps} /></section>
    </>
  );
}

function Opened({ sessionId }: { sessionId: string }) {
  const state = useComputed(() => sessions.value.get(sessionId)).value; // redraws only if this session changes
  const log = useSessionLog(sessionId, toldIn(state));
  useEffect(() => {
    sessionInView.value = sessionId;
    return () => { sessionInView.value = ''; };
  }, [sessionId]);
  if (!state && log.steps.length === 0) {
    if (log.error) return <Failure what="The session" error={log.error} onRetry={log.again} />;
    return log.isReading ? <Loading what="the session" />
      : <Empty title="The daemon does not know this session"><p><Name text={sessionId} /> is neither in memory nor in the audit log. <a href={urlOf('/')}>The overview</a> lists all scenes.</p></Empty>;
  }
  return <Session sessionId={sessionId} state={state} log={log} />;
}

export function SessionView() {
  const sessionId = route.value.parts[0] ?? '';
  const other = route.value.query.get('with');
  return other ? <CompareSessions key={`${sessionId}\n${other}`} ids={[sessionId, other]} /> : <Opened key={sessionId} sessionId={sessionId} />;
}
