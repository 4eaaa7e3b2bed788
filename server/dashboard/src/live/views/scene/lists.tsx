// Lists in the view of a scene: the same scene on other machines, its sessions, and its latest decisions.
import { DecisionOutcome, type DecisionEvent } from '../../../gen/sweepstake/v1/posteriors_pb';
import { bytes, share, significant } from '../../../format';
import { csvUrl } from '../../parts/download';
import { Arm, Arms } from '../../parts/arm';
import { Chip, VerdictChip } from '../../parts/chips';
import { ago, now, timeText } from '../../parts/clock';
import { Name, visible } from '../../parts/name';
import { isChanging, leadersOf } from '../../state/regimes';
import { decisionsHref, route, sceneHref, sessionHref } from '../../state/route';
import { frameTimesOf } from '../../state/savings';
import { leaderProbabilityOf, sceneKey, type SceneName, type SceneState } from '../../state/scenes';
import { isConnected, lastMessageMs, sessions, type SessionState } from '../../state/sessions';
import { summaries, verdictOf } from '../../state/summaries';
import { explained, toldOfEvent } from '../../audit/explain';
import { endWord, modeWord, outcomeWord, stateWord } from '../words';
import { useComputed } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import type { SessionInfo } from '../../../gen/sweepstake/v1/sessions_pb';
import { bucketsOf, type Buckets, countOf, type LogHistogram, merged, type Percentiles, percentiles } from '../../numbers/histogram';
import { type Column, Table } from '../../parts/table';

/** Returns the URL that compares the scene of this view with another one. */
export function besideHref(other: string): string {
  const query = new URLSearchParams(route.value.query);
  query.set('with', other);
  return `${route.value.path}?${query.toString()}`;
}

/** Returns the posteriors of a scene for all classes of machines and versions of the reward. */
export function variantsOf({ project, scene }: SceneName): SceneState[] {
  return summaries.value.map(({ state }) => state).filter(({ posterior }) => posterior.project === project && posterior.scene === scene);
}

// Versions from this number on belong to weights that a game or daemon has set (RewardVersionOf in session/policy_registry.h).
const FIRST_OWN_REWARD_VERSION = 2 ** 30;
const rewardName = (version: number) =>
  (version === 3 ? '3 (detection time)' : version >= FIRST_OWN_REWARD_VERSION ? `${version} (own weights)` : String(version));

function variantColumns(own: string): readonly Column<SceneState>[] {
  return [
    { id: 'class', title: 'Machines', sort: ({ posterior }) => posterior.machineClass,
      cell: ({ posterior, key }) => (key === own ? <b><Name text={posterior.machineClass} /></b> : <a href={sceneHref(posterior)}><Name text={posterior.machineClass} /></a>) },
    { id: 'reward', title: 'Reward', isText: true, sort: ({ posterior }) => posterior.rewardVersion, cell: ({ posterior }) => rewardName(posterior.rewardVersion) },
    { id: 'verdict', title: 'Verdict', isText: true, cell: (state) => <VerdictChip verdict={verdictOf(state)} /> },
    { id: 'leader', title: 'Leader', isText: true, sort: ({ posterior }) => leadersOf(posterior).join(' '), cell: ({ posterior }) => <Arms names={leadersOf(posterior)} /> },
    { id: 'p', title: 'P(best)', hint: 'In a changing scene, the lowest of its regimes', sort: ({ posterior }) => leaderProbabilityOf(posterior),
      cell: ({ posterior }) => (leadersOf(posterior).length > 0 ? leaderProbabilityOf(posterior).toFixed(3) : '–') },
    { id: 'loss', title: 'Loss', sort: ({ posterior }) => posterior.expectedLossRatio, cell: ({ posterior }) => (isChanging(posterior) ? '–' : share(posterior.expectedLossRatio)) },
    { id: 'sources', title: 'Sources', hint: 'Sessions that added evidence', sort: ({ posterior }) => Number(posterior.sourceCount) },
    { id: 'compare', title: 'Comparison', isText: true, cell: ({ key }) => (key === own ? '' : <a href={besideHref(key)}>Compare</a>) },
  ];
}

export function Variants({ name }: { name: SceneName }) {
  const variants = variantsOf(name);
  const columns = useMemo(() => variantColumns(sceneKey(name)), [sceneKey(name)]);
  if (variants.length < 2) return <p class="soft">Only one class of machines has played this scene.</p>;
  return <Table caption="Classes of machines" columns={columns} rows={variants} keyOf={({ key }) => key} sort="class" sortParameter="classes" />;
}

const SESSION_COLUMNS: readonly Column<SessionState>[] = [
  { id: 'session', title: 'Session', sort: ({ info }) => info.sessionId, cell: ({ info }) => <a href={sessionHref(info.sessionId)}><Name text={info.sessionId} /></a> },
  { id: 'state', title: 'State', isText: true, sort: (session) => Number(!isConnected(session)),
    cell: (session) => {
      const { name, mark, meaning } = session.ended ? endWord(session.ended.end) : stateWord(session.info.state);
      return <Chip tone={isConnected(session) ? 'good' : 'plain'} sign={mark} title={meaning}>{name}</Chip>;
    } },
  { id: 'arm', title: 'Active algorithm', isText: true, sort: ({ info }) => info.activeArm, cell: ({ info }) => <Arm name={info.activeArm} /> },
  { id: 'frame', title: 'Frame time', hint: 'Median of the latest frames', sort: (session) => frameTimesOf(session).at(-1),
    cell: (session) => { const ms = frameTimesOf(session).at(-1); return ms === undefined ? '–' : `${significant(ms)} ms`; } },
  { id: 'class', title: 'Machines', isText: true, hint: 'Class of machines, known after the first decision since the page was opened', sort: ({ decisions }) => decisions.at(-1)?.machineClass },
  { id: 'mode', title: 'Mode', isText: true, sort: ({ info }) => modeWord(info.mode).name },
  { id: 'build', title: 'Build', isText: true, sort: ({ info }) => info.build },
  { id: 'start', title: 'Began', sort: ({ info }) => Number(info.unixStartMs), cell: ({ info }) => timeText(Number(info.unixStartMs)) },
  { id: 'last', title: 'Last message', sort: lastMessageMs,
    cell: (session) => (lastMessageMs(session) > 0 ? ago(lastMessageMs(session), now.value) : '–') },
  { id: 'dropped', title: 'Dropped frames', hint: 'Frames that the game measured but could not send', sort: ({ info }) => Number(info.droppedFrameCount) },
];

export function Sessions({ name }: { name: SceneName }) {
  const own = [...sessions.value.values()].filter(({ info }) => info.project === name.project && info.scene === name.scene);
  if (own.length === 0) return <p class="soft">No game plays this scene now. <a href={decisionsHref({ project: name.project, scene: name.scene })}>Earlier sessions are in the log.</a></p>;
  return <Table caption="Sessions" csvHref={csvUrl('sessions', { project: name.project, scene: name.scene })} columns={SESSION_COLUMNS} rows={own} keyOf={({ info }) => info.sessionId} sort="state" sortParameter="sessions" />;
}

const SHOWN_DECISIONS = 12;
const QUIET = new Set([DecisionOutcome.KEPT, DecisionOutcome.NO_FRAMES, DecisionOutcome.HELD_SETTLING]);

/** The latest decisions that changed something or were held back. */
export function Latest({ decisions, rewardVersion }: { decisions: readonly DecisionEvent[]; rewardVersion: number }) {
  const shown = decisions.filter(({ outcome }) => !QUIET.has(outcome)).slice(-SHOWN_DECISIONS).reverse();
  if (shown.length === 0) return <p class="soft">Every decision since the page was opened kept the active algorithm.</p>;
  return (
    <ul class="latest">
      {shown.map((event) => (
        <li key={`${event.sessionId} ${event.decisionId}`}>
          {timeText(Number(event.unixMs))} <a href={`${sessionHref(event.sessionId)}?decision=${event.decisionId}`}>{outcomeWord(event.outcome).name}</a>{' '}
          <bdi>{visible(explained(toldOfEvent(event, rewardVersion))[0] ?? '')}</bdi>
        </li>
      ))}
    </ul>
  );
}

export interface BuildRow {
  build: string; // '': unknown
  sessionCount: number;
  onlineCount: number;
  droppedCount: number;
  frameCount: number; // frames in the percentiles
  frameNs: Percentiles | undefined;
  detectionNs: Percentiles | undefined;
  nativeBytes: Percentiles | undefined;
}

type Part = 'frameTimeNs' | 'detectionTimeNs' | 'nativeBytes';

function bucketsIn(all: readonly SessionState[], part: Part): Buckets {
  const histograms = all.flatMap(({ decisions }) => decisions.map(({ measurements }) => measurements?.[part]));
  return merged(histograms.filter((each): each is NonNullable<typeof each> => each !== undefined).map((each: LogHistogram) => bucketsOf(each)));
}

export function buildRows(all: readonly SessionState[]): BuildRow[] {
  return [...new Set(all.map(({ info }) => info.build))].map((build) => {
    const own = all.filter(({ info }) => info.build === build);
    const frames = bucketsIn(own, 'frameTimeNs');
    return {
      build,
      sessionCount: own.length,
      onlineCount: own.filter(isConnected).length,
      droppedCount: own.reduce((sum, { info }) => sum + Number(info.droppedFrameCount), 0),
      frameCount: countOf(frames),
      frameNs: percentiles(frames),
      detectionNs: percentiles(bucketsIn(own, 'detectionTimeNs')),
      nativeBytes: percentiles(bucketsIn(own, 'nativeBytes')),
    };
  });
}

/** Returns when the first session of each build began. */
export function buildStarts(all: readonly SessionInfo[]): { build: string; fromMs: number }[] {
  const starts = new Map<string, number>();
  for (const { build, unixStartMs } of all) {
    if (build) starts.set(build, Math.min(starts.get(build) ?? Number.POSITIVE_INFINITY, Number(unixStartMs)));
  }
  return [...starts].map(([build, fromMs]) => ({ build, fromMs })).sort((a, b) => a.fromMs - b.fromMs || a.build.localeCompare(b.build));
}

const ms = (ns: number) => `${significant(ns / 1e6)} ms`;
const PLACES = [['p50', 0], ['p95', 1], ['p99', 2]] as const;
const three = (id: string, title: string, values: (row: BuildRow) => Percentiles | undefined, text: (value: number) => string): Column<BuildRow>[] =>
  PLACES.map(([name, place]) => ({
    id: `${id}-${name}`, title: `${title} ${name}`, sort: (row: BuildRow) => values(row)?.[place],
    cell: (row: BuildRow) => { const value = values(row)?.[place]; return value === undefined ? '–' : text(value); },
  }));

const COLUMNS: readonly Column<BuildRow>[] = [
  { id: 'build', title: 'Build', sort: ({ build }) => build },
  { id: 'sessions', title: 'Sessions', sort: ({ sessionCount }) => sessionCount, cell: ({ sessionCount, onlineCount }) => `${sessionCount}, ${onlineCount} online` },
  ...three('frame', 'Frame', ({ frameNs }) => frameNs, ms),
  ...three('detection', 'Detection', ({ detectionNs }) => detectionNs, ms),
  ...three('memory', 'Memory', ({ nativeBytes }) => nativeBytes, bytes).slice(1, 2),
  { id: 'frames', title: 'Frames', hint: 'Number of frames in the percentiles', sort: ({ frameCount }) => frameCount },
  { id: 'dropped', title: 'Dropped', hint: 'Frames that games measured but could not send', sort: ({ droppedCount }) => droppedCount },
];

export function Builds({ name: { project, scene } }: { name: SceneName }) {
  const own = useComputed(() => [...sessions.value.values()].filter(({ info }) => info.project === project && info.scene === scene)).value;
  if (own.length === 0) return <p class="soft">The daemon has no session of this scene in memory.</p>;
  return <Table caption="Builds" columns={COLUMNS} rows={buildRows(own)} keyOf={({ build }) => build} sort="build" sortParameter="builds" />;
}
