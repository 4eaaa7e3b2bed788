// Lists in the view of a scene: the same scene on other machines, its sessions, and its latest decisions.
import { DecisionOutcome, type DecisionEvent } from '../../../gen/sweepstake/v1/posteriors_pb';
import { bytes, grouped, share, significant } from '../../../format';
import { csvUrl } from '../../parts/download';
import { Arm, Arms } from '../../parts/arm';
import { Chip, VerdictChip } from '../../parts/chips';
import { ago, now, timeText } from '../../parts/clock';
import { Name, visible } from '../../parts/name';
import { isChanging, leadersOf, savingWithShare } from '../../state/regimes';
import { decisionsHref, hrefWith, sceneHref, sessionHref } from '../../state/route';
import { leaderProbabilityOf, sceneKey, type SceneName, type SceneState } from '../../state/scenes';
import { connectedSessions, frameTimesOf, isConnected, lastMessageMs, sessions, type SessionState } from '../../state/sessions';
import { summaries, verdictOf } from '../../state/summaries';
import { explained, toldOfEvent } from '../../audit/explain';
import { endWord, modeWord, outcomeWord, stateWord } from '../words';
import { useComputed } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { HistoryKind, type HistoryPoint, type HistorySeries } from '../../../gen/sweepstake/v1/history_pb';
import { percentiles } from '../../numbers/histogram';
import { type Use, measuredIn, REFERENCE_ARM, SAVINGS } from '../../numbers/use';
import { type HistoryReading, useHistory, WHOLE_LIFE } from '../../transport/history';
import { type Column, Table } from '../../parts/table';

export const variantsOf = ({ project, scene }: SceneName): SceneState[] =>
  summaries.value.map(({ state }) => state).filter(({ posterior }) => posterior.project === project && posterior.scene === scene);

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
      cell: ({ posterior }) => (leaderProbabilityOf(posterior) > 0 ? leaderProbabilityOf(posterior).toFixed(3) : '–') },
    { id: 'loss', title: 'Loss', sort: ({ posterior }) => posterior.expectedLossRatio, cell: ({ posterior }) => (isChanging(posterior) ? '–' : share(posterior.expectedLossRatio)) },
    { id: 'sources', title: 'Sources', hint: 'Sessions that added evidence', sort: ({ posterior }) => Number(posterior.sourceCount) },
    { id: 'compare', title: 'Comparison', isText: true, cell: ({ key }) => (key === own ? '' : <a href={hrefWith('with', key)}>Compare</a>) },
  ];
}

export function Variants({ name }: { name: SceneName }) {
  const variants = variantsOf(name);
  const columns = useMemo(() => variantColumns(sceneKey(name)), [sceneKey(name)]);
  if (variants.length < 2) return <p class="soft">Only one class of machines has played this scene.</p>;
  return <Table caption="Classes of machines" columns={columns} rows={variants} keyOf={({ key }) => key} sort="class" sortParameter="classes" />;
}

interface Used { use?: Use | undefined }
const SAVED = SAVINGS.map(([part, against], i): Column<Used> => ({
  id: `saved-${i}`, title: ['Saved per frame', 'Saved, best single', `Saved, ${REFERENCE_ARM}`][i]!, isDetail: i > 0,
  hint: `Detection time per frame that was saved against ${against}, with the cost of switches, and its share of the frame time`,
  sort: ({ use }) => (use?.[part] === undefined ? undefined : use[part] / use.frameCount),
  cell: ({ use }) => (use?.[part] === undefined ? '–' : savingWithShare(use[part] / use.frameCount, use[part] / use.frameUs)),
}));

interface SessionRow extends SessionState { use?: Use | undefined }

const SESSION_COLUMNS: readonly Column<SessionRow>[] = [
  { id: 'session', title: 'Session', sort: ({ info }) => info.sessionId, cell: ({ info }) => <a href={sessionHref(info.sessionId)}><Name text={info.sessionId} /></a> },
  { id: 'state', title: 'State', isText: true, sort: (session) => Number(!isConnected(session)),
    cell: (session) => {
      const { name, mark, meaning } = session.ended ? endWord(session.ended.end) : stateWord(session.info.state);
      return <Chip tone={isConnected(session) ? 'good' : 'plain'} sign={mark} title={meaning}>{name}</Chip>;
    } },
  { id: 'arm', title: 'Active algorithm', isText: true, sort: ({ info }) => info.activeArm, cell: ({ info }) => <Arm name={info.activeArm} /> },
  { id: 'frame', title: 'Frame time', hint: 'Median of the latest frames', sort: (session) => frameTimesOf(session).at(-1),
    cell: (session) => { const ms = frameTimesOf(session).at(-1); return ms === undefined ? '–' : `${significant(ms)} ms`; } },
  ...SAVED,
  { id: 'class', title: 'Machines', isText: true, hint: 'Class of machines', sort: ({ info }) => info.machineClass },
  { id: 'mode', title: 'Mode', isText: true, sort: ({ info }) => modeWord(info.mode).name },
  { id: 'build', title: 'Build', isText: true, sort: ({ info }) => info.build },
  { id: 'start', title: 'Began', sort: ({ info }) => Number(info.unixStartMs), cell: ({ info }) => timeText(Number(info.unixStartMs)) },
  { id: 'last', title: 'Last message', sort: lastMessageMs,
    cell: (session) => (lastMessageMs(session) > 0 ? ago(lastMessageMs(session), now.value) : '–') },
  { id: 'dropped', title: 'Dropped frames', hint: 'Frames that the game measured but could not send', sort: ({ info }) => Number(info.droppedFrameCount) },
];

export function Sessions({ name }: { name: SceneName }) {
  const own = [...sessions.value.values()].filter(({ info }) => info.project === name.project && info.scene === name.scene);
  const { series } = useHistory({ kind: HistoryKind.SESSION, project: name.project, scene: name.scene }, WHOLE_LIFE);
  const uses = useMemo(() => new Map(series.map(({ sessionId, points }) => [sessionId, measuredIn(points[0]!)])), [series]);
  if (own.length === 0) return <p class="soft">No game plays this scene now. <a href={decisionsHref({ project: name.project, scene: name.scene })}>Earlier sessions are in the log.</a></p>;
  const rows = own.map((session): SessionRow => ({ ...session, use: uses.get(session.info.sessionId) }));
  return <Table caption="Sessions" csvHref={csvUrl('sessions', { project: name.project, scene: name.scene })} columns={SESSION_COLUMNS} rows={rows} keyOf={({ info }) => info.sessionId} sort="state" sortParameter="sessions" />;
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

interface BuildRow { build: string; point: HistoryPoint; onlineCount: number; use: Use | undefined }

const three = (part: 'frameTimeNs' | 'detectionTimeNs' | 'nativeBytes', id: string, title: string, text: (value: number) => string): Column<BuildRow>[] =>
  (['p50', 'p95', 'p99'] as const).map((name, place) => ({
    id: `${id}-${name}`, title: `${title} ${name}`, sort: ({ point }: BuildRow) => percentiles(point[part])?.[place],
    cell: ({ point }: BuildRow) => { const value = percentiles(point[part])?.[place]; return value === undefined ? '–' : text(value); },
  }));
const msText = (ns: number) => `${significant(ns / 1e6)} ms`;
const usText = (ns: number) => `${significant(ns / 1000)} µs`;

const COLUMNS: readonly Column<BuildRow>[] = [
  { id: 'build', title: 'Build', sort: ({ build }) => build },
  { id: 'sessions', title: 'Sessions', sort: ({ point }) => Number(point.sessionCount), cell: ({ point, onlineCount }) => `${grouped(Number(point.sessionCount))}, ${onlineCount} online` },
  ...three('frameTimeNs', 'frame', 'Frame', msText),
  ...three('detectionTimeNs', 'detection', 'Detection', usText),
  ...SAVED,
  ...three('nativeBytes', 'memory', 'Memory', bytes).slice(1, 2),
  { id: 'frames', title: 'Frames', hint: 'Number of measured frames', sort: ({ point }) => Number(point.frameCount) },
  { id: 'switches', title: 'Switches', sort: ({ point }) => Number(point.switchCount) },
  { id: 'first', title: 'First played', sort: ({ point }) => Number(point.unixMs), cell: ({ point }) => timeText(Number(point.unixMs)) },
  { id: 'last', title: 'Last played', sort: ({ point }) => Number(point.endUnixMs), cell: ({ point }) => timeText(Number(point.endUnixMs)) },
];

/** The latest two builds by the time at which they were first played, then by name; undefined if there are fewer. */
export function latestBuilds(series: HistoryReading['series']): [HistorySeries, HistorySeries] | undefined {
  const [before, last] = series.filter(({ build }) => build !== '')
    .sort((a, b) => Number(a.points[0]!.unixMs - b.points[0]!.unixMs) || a.build.localeCompare(b.build, 'en', { numeric: true })).slice(-2);
  return before && last && [before, last];
}

/** Returns a time of a build, how much it differs from that of the build before, and that build's time. */
export function changed(ns: number | undefined, before: number | undefined, build: string, text: (value: number) => string): string {
  if (ns === undefined || !before) return 'that is not known';
  const ratio = share(Math.abs(ns / before - 1));
  return `of ${text(ns)}, ${ratio === '0 %' ? 'the same as' : `${ratio} ${ns > before ? 'more' : 'less'} than`} build ${visible(build)}${ratio === '0 %' ? '' : ` (${text(before)})`}`;
}

/** Compares the latest two builds. */
export function BuildChange({ builds: { series } }: { builds: HistoryReading }) {
  const [before, last] = latestBuilds(series) ?? [];
  if (!before || !last) return null;
  const change = (name: 'frameTimeNs' | 'detectionTimeNs', text: (value: number) => string) =>
    changed(percentiles(last.points[0]![name])?.[0], percentiles(before.points[0]![name])?.[0], before.build, text);
  return <p>Build <b><Name text={last.build} /></b> has a median detection time <b><bdi>{change('detectionTimeNs', usText)}</bdi></b>, and a median frame time <bdi>{change('frameTimeNs', msText)}</bdi>.</p>;
}

/** The builds that have played the scene, over their whole lives. */
export function Builds({ name: { project, scene, machineClass }, builds: { series, wasRead, error } }: { name: SceneName; builds: HistoryReading }) {
  const online = useComputed(() => connectedSessions.value.filter(({ info }) => info.project === project && info.scene === scene && info.machineClass === machineClass).map(({ info }) => info.build)).value;
  if (series.length === 0) return <p class="soft">{error ? error.message : wasRead ? 'The history has no build of this scene on this class of machines.' : 'Reading the history.'}</p>;
  const rows = series.map(({ build, points }): BuildRow => ({ build, point: points[0]!, onlineCount: online.filter((each) => each === build).length, use: measuredIn(points[0]!) }));
  return <Table caption="Builds" csvHref={csvUrl('history', { kind: 'HISTORY_KIND_BUILD', project, scene, maxPoints: 1 })} columns={COLUMNS} rows={rows} keyOf={({ build }) => build} sort="build" sortParameter="builds" />;
}
