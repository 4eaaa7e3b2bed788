// The overview: all scenes, the least certain first, and the problems that need attention.
import { counted, grouped, share, significant } from '../../format';
import { Arm, Arms } from '../parts/arm';
import { VerdictChip } from '../parts/chips';
import { ago, now } from '../parts/clock';
import { CopyLink } from '../parts/toast';
import { Choice, Filter, matches } from '../parts/filter';
import { Name, visible } from '../parts/name';
import { Sparkline } from '../parts/sparkline';
import { Empty, Failure, Loading } from '../parts/states';
import { type Column, Table, useEntered } from '../parts/table';
import { thresholds } from '../state/account';
import { connection } from '../state/connection';
import { trendOf } from '../state/history';
import { isKnown } from '../state/live';
import { isChanging, leadersOf, savingText } from '../state/regimes';
import { route, sceneHref, sessionHref } from '../state/route';
import { type SceneSummary, summaries } from '../state/summaries';
import { GLOSSARY, verdictWord } from './words';
import { useEffect, useRef } from 'preact/hooks';
import { SessionState as Link } from '../../gen/sweepstake/v1/sessions_pb';
import { Mode, SwitchReason, Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { checks, followChecks } from '../state/health';
import { groupedBy } from '../state/scenes';
import { connectedSessions, sessions, type SessionState } from '../state/sessions';
import { urlOf } from '../transport/base';

const sceneOf = ({ state }: SceneSummary) => state.posterior;
const hasLeader = (row: SceneSummary) => leadersOf(sceneOf(row)).length > 0;
// In a changing scene no single arm is the choice, so there is no loss of choosing it.
const lossOf = (row: SceneSummary) => (hasLeader(row) && !isChanging(sceneOf(row)) ? sceneOf(row).expectedLossRatio : undefined);

const COLUMNS: readonly Column<SceneSummary>[] = [
  { id: 'scene', title: 'Scene', sort: (row) => `${sceneOf(row).project}\n${sceneOf(row).scene}`, csv: (row) => sceneOf(row).scene,
    cell: (row) => <a href={sceneHref(sceneOf(row))}><Name text={sceneOf(row).scene} /></a> },
  { id: 'verdict', title: 'Verdict', isText: true, width: '8rem', hint: 'Says whether the best arm is known. This column sorts by uncertainty.', sort: (row) => row.uncertainty,
    csv: (row) => verdictWord(row.verdict).name, cell: (row) => <VerdictChip verdict={row.verdict} /> },
  { id: 'leader', title: 'Leader', isText: true, width: '8rem', hint: 'The arm with the highest probability of being the best; in a changing scene, the best arm of each regime', sort: (row) => leadersOf(sceneOf(row)).join(' '),
    cell: (row) => <Arms names={leadersOf(sceneOf(row))} /> },
  { id: 'p', title: 'P(best)', hint: 'Probability that the leader is the best arm; in a changing scene, the lowest of its regimes', sort: (row) => (hasLeader(row) ? row.leaderProbability : undefined),
    cell: (row) => (hasLeader(row) ? row.leaderProbability.toFixed(3) : '–') },
  { id: 'runs', title: 'Runs now', isText: true, width: '8rem', hint: 'The arm that runs now in the session that has been connected the longest', sort: (row) => sceneOf(row).activity?.activeArm,
    cell: (row) => { const arm = sceneOf(row).activity?.activeArm; return arm ? <Arm name={arm} /> : '–'; } },
  { id: 'saved', title: 'Saved', width: '7rem', hint: 'Detection time per frame that this session saved against the best single arm', sort: (row) => sceneOf(row).activity?.total?.savedAgainstSingleUs,
    cell: (row) => savingText(sceneOf(row).activity?.total?.savedAgainstSingleUs) ?? '–' },
  { id: 'trend', title: 'Trend', isText: true, hint: 'P(best) of the leader since the page was opened, from 0 to 1. The dotted line is the threshold of stable scenes.',
    cell: (row) => <Sparkline values={trendOf(row.state.history)} low={0} high={1} mark={thresholds.value.stableProbability} /> },
  { id: 'loss', title: 'Loss', width: '6rem', hint: 'Expected extra cost of choosing the leader instead of the best arm', sort: lossOf,
    cell: (row) => { const loss = lossOf(row); return loss === undefined ? '–' : share(loss); } },
  { id: 'sessions', title: 'Sessions', hint: 'Sessions connected now', sort: (row) => sceneOf(row).activeSessionCount },
  { id: 'evidence', title: 'Evidence', width: '7rem', hint: 'Decision windows and visits of the shadow lane in all sessions', sort: (row) => Number(row.evidence) },
  { id: 'changed', title: 'Changed', width: '7rem', hint: 'Time of the last change that this page received. If there was none: time of the latest evidence', sort: (row) => row.state.changedMs || undefined,
    cell: (row) => (row.state.changedMs ? ago(row.state.changedMs, now.value) : '–') },
  { id: 'project', title: 'Project', isText: true, sort: (row) => sceneOf(row).project },
  { id: 'class', title: 'Machines', isText: true, hint: 'Class of machines', sort: (row) => sceneOf(row).machineClass },
  { id: 'reward', title: 'Reward', hint: 'Version of the formula that turns a cost into a reward; AI Decides uses version 3', sort: (row) => sceneOf(row).rewardVersion },
];

const VERDICTS = [Verdict.DEGRADED, Verdict.AMBIGUOUS, Verdict.UNSPECIFIED, Verdict.TIE, 'changing', Verdict.STABLE] as const;

function Figure({ value, what, title }: { value: string; what: string; title?: string }) {
  return <div class="figure" title={title}><b>{value}</b><span>{what}</span></div>;
}

function Figures() {
  const all = summaries.value;
  const lastMs = Math.max(0, ...all.map(({ state }) => state.changedMs));
  const unsure = all.filter(isUnsettled).length;
  return (
    <div class="figures">
      <Figure value={grouped(all.length)} what={all.length === 1 ? 'scene' : 'scenes'} />
      <Figure value={grouped(connectedSessions.value.length)} what={connectedSessions.value.length === 1 ? 'session online' : 'sessions online'} />
      <Figure value={grouped(unsure)} what="not settled" title="Scenes with the verdict ambiguous or degraded" />
      <Figure value={lastMs ? ago(lastMs, now.value) : '–'} what="last change" title="Time of the last change that this page received. If there was none: time of the latest evidence" />
    </div>
  );
}

function filtered(all: readonly SceneSummary[]): readonly SceneSummary[] {
  const { query } = route.value;
  const text = query.get('q') ?? '';
  const verdict = VERDICTS.map((each) => verdictWord(each).name).find((name) => name === query.get('verdict'));
  const project = query.get('project') ?? '';
  const isOnline = query.get('online') === 'yes';
  return all.filter((row) => {
    const { posterior } = row.state;
    return (verdict === undefined || verdictWord(row.verdict).name === verdict) && (project === '' || posterior.project === project)
      && (!isOnline || posterior.activeSessionCount > 0)
      && matches(text, [posterior.project, posterior.scene, posterior.machineClass, ...leadersOf(posterior)]);
  });
}

function Tools({ all }: { all: readonly SceneSummary[] }) {
  const projects = [...new Set(all.map(({ state }) => state.posterior.project))].sort();
  return (
    <>
      <Filter label="Search scenes" />
      <Choice label="Verdict" parameter="verdict" options={[['any', 'any'], ...VERDICTS.map((each) => [verdictWord(each).name, verdictWord(each).name] as const)]} />
      <Choice label="Project" parameter="project" options={[['', 'all'], ...projects.map((each) => [each, visible(each)] as const)]} />
      <Choice label="Sessions" parameter="online" options={[['', 'any'], ['yes', 'online']]} />
      <CopyLink />
    </>
  );
}

interface Project { project: string; scenes: readonly SceneSummary[]; worst: SceneSummary }

const isUnsettled = ({ verdict }: SceneSummary) => verdict === Verdict.AMBIGUOUS || verdict === Verdict.DEGRADED;

const projectsOf = (all: readonly SceneSummary[]): Project[] => [...groupedBy(all, (row) => sceneOf(row).project)].map(([project, own]) =>
  ({ project, scenes: own, worst: own.reduce((worst, row) => (row.uncertainty > worst.uncertainty ? row : worst)) }));

const PROJECTS: readonly Column<Project>[] = [
  { id: 'project', title: 'Project', sort: ({ project }) => project, cell: ({ project }) => <a href={urlOf(`/?project=${encodeURIComponent(project)}`)}><Name text={project} /></a> },
  { id: 'verdict', title: 'Least certain scene', isText: true, hint: 'The scene of the project whose best arm is least certain. This column sorts by uncertainty.', sort: ({ worst }) => worst.uncertainty,
    csv: ({ worst }) => sceneOf(worst).scene, cell: ({ worst }) => <><VerdictChip verdict={worst.verdict} /> <a href={sceneHref(sceneOf(worst))}><Name text={sceneOf(worst).scene} /></a></> },
  { id: 'unsettled', title: 'Not settled', hint: 'Scenes with the verdict ambiguous or degraded', sort: (row) => row.scenes.filter(isUnsettled).length },
  { id: 'scenes', title: 'Scenes', sort: (row) => row.scenes.length },
  { id: 'sessions', title: 'Sessions', hint: 'Sessions connected now', sort: (row) => row.scenes.reduce((sum, each) => sum + sceneOf(each).activeSessionCount, 0) },
  { id: 'evidence', title: 'Evidence', hint: 'Decision windows and visits of the shadow lane in all sessions', sort: (row) => row.scenes.reduce((sum, { evidence }) => sum + Number(evidence), 0) },
];

function Projects({ all }: { all: readonly SceneSummary[] }) {
  const rows = projectsOf(all);
  if (rows.length < 2) return null;
  return (
    <section aria-labelledby="projects-heading">
      <h2 id="projects-heading">Projects</h2>
      <Table caption="Projects" columns={PROJECTS} rows={rows} keyOf={({ project }) => project} sort="-verdict" sortParameter="projects" />
    </section>
  );
}

function NoScenes() {
  return (
    <Empty title="No scene has reported yet">
      <p>A scene appears here as soon as a game has played it. To try this without a game, run:</p>
      <pre>sweepstake run --scene hurricane --objects 3000 --mode ai --daemon HOST:PORT</pre>
    </Empty>
  );
}

export function Overview() {
  const all = summaries.value;
  if (all.length === 0 && !isKnown.value.scenes) return connection.value.status === 'connecting' ? <Loading what="scenes" /> : <NotThere />;
  const rows = filtered(all);
  return (
    <>
      <h1 class="unseen">Overview</h1>
      <div class="summary"><Figures /><Attention /></div>
      <section aria-labelledby="scenes-heading">
        <h2 id="scenes-heading">Scenes</h2>
        {all.length === 0 ? <NoScenes /> : (
          <Table caption="Scenes" columns={COLUMNS} rows={rows} keyOf={({ state }) => state.key} sort="-verdict" tools={<Tools all={all} />} />
        )}
        {all.length > 0 && rows.length === 0 && <Empty title="No scene matches the filter" />}
      </section>
      <Projects all={all} />
      <p class="soft small">The page knows {counted(sessions.value.size, 'session', 'sessions')}. A verdict uses the evidence of all sessions. A scene is changing if its regimes have different best arms, and stable if P(best) of its leader is at least {significant(thresholds.value.stableProbability, 1)}.</p>
      <details class="soft small">
        <summary>Terms on this page</summary>
        <dl>{GLOSSARY.map(([name, meaning]) => [<dt key={name}>{name}</dt>, <dd key={`${name}=`}>{meaning}</dd>])}</dl>
      </details>
    </>
  );
}

function NotThere() {
  const { error } = connection.value;
  if (error && error.code !== 'UNREACHABLE') return <Failure what="The scenes" error={error} onRetry={() => location.reload()} />;
  return <Empty title="No connection to the daemon"><p>Reason: {error?.message ?? 'the connection was lost'}. The page reconnects automatically.</p></Empty>;
}

interface Concern {
  text: string;
  places: readonly { href: string; name: string }[];
  isBad: boolean;
  allHref?: string; // URL of a view that lists all places
}

const MAX_PLACES = 3; // links per problem
const LATELY_MS = 600_000; // older bail-outs are not listed

const ofScene = ({ state }: SceneSummary) => ({ href: sceneHref(state.posterior), name: state.posterior.scene });
const ofSession = ({ info }: SessionState) => ({ href: sessionHref(info.sessionId), name: `${info.scene} (${info.sessionId.slice(0, 8)})` });

function concern(found: readonly (SceneSummary | SessionState)[], one: string, many: string, isBad: boolean, allHref?: string): Concern | undefined {
  if (found.length === 0) return undefined;
  return { text: counted(found.length, one, many), isBad, ...(allHref && { allHref }), places: found.map((each) => ('state' in each ? ofScene(each) : ofSession(each))) };
}

const bailsOut = ({ state }: SceneSummary) =>
  state.decisions.slice(-50).some(({ reason, unixMs }) => reason === SwitchReason.BAIL_OUT && now.value - Number(unixMs) < LATELY_MS);

function concerns(): Concern[] {
  const all = summaries.value;
  const online = connectedSessions.value;
  const lost = [...sessions.value.values()].filter(({ info, ended }) => !ended && info.state === Link.LOST);
  const failed = (checks.value ?? []).filter(({ isOk, note }) => !isOk || note !== '');
  return [
    ...failed.map(({ name, isOk, note }): Concern => ({ text: `${name}: ${note || 'failed'}`, isBad: !isOk, places: [{ href: urlOf('/health'), name: 'health' }] })),
    concern(all.filter(({ verdict }) => verdict === Verdict.DEGRADED), 'scene misses the frame-rate floor even with its best arm',
      'scenes miss the frame-rate floor even with their best arms', true, urlOf('/?verdict=degraded')),
    concern(all.filter(bailsOut), 'scene had a bail-out in the last 10 minutes', 'scenes had bail-outs in the last 10 minutes', true),
    concern(lost, 'session has lost the connection to its game', 'sessions have lost the connection to their games', false),
    concern(online.filter(({ info }) => info.droppedFrameCount > 0n), 'game has dropped measurements', 'games have dropped measurements', false),
    concern(online.filter(({ info }) => info.mode === Mode.MANUAL), 'session is in manual mode and adds no evidence',
      'sessions are in manual mode and add no evidence', false),
  ].filter((each) => each !== undefined);
}

function Item({ text, places, isBad, allHref }: Concern) {
  const rest = places.length - MAX_PLACES;
  return (
    <li class={isBad ? 'bad' : 'warn'}>
      <span aria-hidden="true">{isBad ? '▲ ' : '△ '}</span>{text}:{' '}
      {places.slice(0, MAX_PLACES).map(({ href, name }, i) => <span key={href}>{i > 0 && ', '}<a href={href}><bdi>{visible(name)}</bdi></a></span>)}
      {rest > 0 && <> and {allHref ? <a href={allHref}>{grouped(rest)} more</a> : `${grouped(rest)} more`}</>}
    </li>
  );
}

// The list of problems. It has a fixed size, and does not change while the pointer or the focus is in it.
export function Attention() {
  useEffect(followChecks, []);
  const { isEntered, handlers } = useEntered();
  const latest = concerns();
  const shown = useRef(latest);
  if (!isEntered) shown.current = latest;
  return (
    <section class="attention" aria-labelledby="attention-heading" {...handlers}>
      <h2 id="attention-heading">Needs attention</h2>
      {shown.current.length === 0 ? <p class="soft">Nothing.</p> : <ul>{shown.current.map((each) => <Item key={each.text} {...each} />)}</ul>}
    </section>
  );
}
