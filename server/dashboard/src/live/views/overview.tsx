// The overview: what choosing algorithms saves, the problems that need attention, and all scenes, the least certain first.
import { useMemo } from 'preact/hooks';
import { counted, grouped, share, significant } from '../../format';
import { HistoryKind } from '../../gen/sweepstake/v1/history_pb';
import { Verdict } from '../../gen/sweepstake/v1/telemetry_pb';
import { measuredIn, savingsOf, sumOf } from '../numbers/use';
import { PERIODS } from '../charts/view_state';
import { csvUrl } from '../parts/download';
import { VerdictChip } from '../parts/chips';
import { Choice, Filter, matches } from '../parts/filter';
import { Name, visible } from '../parts/name';
import { Empty, Failure, Loading } from '../parts/states';
import { type Column, Table } from '../parts/table';
import { CopyLink } from '../parts/toast';
import { stableProbability } from '../state/account';
import { connection } from '../state/connection';
import { areScenesKnown } from '../state/live';
import { leadersOf, savingText } from '../state/regimes';
import { route, sceneHref } from '../state/route';
import { groupedBy } from '../state/scenes';
import { connectedSessions, sessions } from '../state/sessions';
import { type SceneSummary, summaries } from '../state/summaries';
import { urlOf } from '../transport/calls';
import { useHistory } from '../transport/history';
import { Attention } from './overview/attention';
import { SCENE_COLUMNS } from './overview/columns';
import { GLOSSARY, verdictWord } from './words';

const sceneOf = ({ state }: SceneSummary) => state.posterior;
const VERDICTS = [Verdict.DEGRADED, Verdict.AMBIGUOUS, Verdict.UNSPECIFIED, Verdict.TIE, 'changing', Verdict.STABLE] as const;

const LATELY = { maxPoints: 1, period: PERIODS.find(({ name }) => name === 'day')!, everyMs: 60_000 };

function Saving() {
  const { series, wasRead, error } = useHistory({ kind: HistoryKind.SCENE }, LATELY);
  const total = useMemo(() => sumOf(series.map(({ points }) => measuredIn(points[0]!))), [series]);
  if (!total) return <div class="figure main"><b>–</b><span>{error ? error.message : wasRead ? 'No session has measured in the last day what it saves.' : 'Reading the history.'}</span></div>;
  const [first, ...others] = savingsOf(total);
  if (!first) return null;
  const wordOf = (us: number) => (us < 0 ? 'lost' : 'saved');
  return (
    <div class={first.us > 0 ? 'figure main good' : 'figure main'} title={`${grouped(total.frameCount)} measured frames`}>
      <b>{savingText(Math.abs(first.us))}</b>
      <span>{wordOf(first.us)} per frame against {first.against} ({share(Math.abs(first.ratio))} of the frame time)
        {others.map(({ us, against }) => `, ${savingText(Math.abs(us))} ${wordOf(us)} against ${against}`)};
        {' '}{counted(series.length, 'scene', 'scenes')} in the last day</span>
    </div>
  );
}

const Figure = ({ value, what, title }: { value: string; what: string; title?: string }) => <div class="figure" title={title}><b>{value}</b><span>{what}</span></div>;

function Figures() {
  const all = summaries.value;
  const [sessionCount, settled] = [connectedSessions.value.length, all.filter(isSettled).length];
  return (
    <div class="figures">
      <Saving />
      <Figure value={grouped(sessionCount)} what={sessionCount === 1 ? 'session is connected' : 'sessions are connected'} />
      <Figure value={`${grouped(settled)} of ${grouped(all.length)}`} what="scenes need no more measurements" title="Scenes with the verdict stable, tie or changing" />
    </div>
  );
}

function filtered(all: readonly SceneSummary[], query: URLSearchParams): readonly SceneSummary[] {
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

const isSettled = ({ verdict }: SceneSummary) => verdict === Verdict.STABLE || verdict === Verdict.TIE || verdict === 'changing';

const projectsOf = (all: readonly SceneSummary[]): Project[] => [...groupedBy(all, (row) => sceneOf(row).project)].map(([project, own]) =>
  ({ project, scenes: own, worst: own.reduce((worst, row) => (row.uncertainty > worst.uncertainty ? row : worst)) }));

const PROJECTS: readonly Column<Project>[] = [
  { id: 'project', title: 'Project', sort: ({ project }) => project, cell: ({ project }) => <a href={urlOf(`/?project=${encodeURIComponent(project)}`)}><Name text={project} /></a> },
  { id: 'verdict', title: 'Least certain scene', isText: true, hint: 'The scene of the project whose best algorithm is least certain. This column sorts by uncertainty.', sort: ({ worst }) => worst.uncertainty,
    cell: ({ worst }) => <><VerdictChip verdict={worst.verdict} /> <a href={sceneHref(sceneOf(worst))}><Name text={sceneOf(worst).scene} /></a></> },
  { id: 'settled', title: 'Settled', hint: 'Scenes with the verdict stable, tie or changing', sort: (row) => row.scenes.filter(isSettled).length },
  { id: 'scenes', title: 'Scenes', sort: (row) => row.scenes.length },
  { id: 'sessions', title: 'Sessions', hint: 'Sessions connected now', sort: (row) => row.scenes.reduce((sum, each) => sum + sceneOf(each).activeSessionCount, 0) },
  { id: 'evidence', title: 'Measurements', hint: 'Windows and visits of the shadow lane in all sessions', sort: (row) => row.scenes.reduce((sum, { evidence }) => sum + Number(evidence), 0) },
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

const NoScenes = () => (
  <Empty title="No scene has reported yet">
    <p>A scene appears here as soon as a game has played it. To try this without a game, run:</p>
    <pre>sweepstake run --scene hurricane --objects 3000 --mode ai --daemon HOST:PORT</pre>
  </Empty>
);

export function Overview() {
  const all = summaries.value;
  if (all.length === 0 && !areScenesKnown.value) return connection.value.status === 'connecting' ? <Loading what="scenes" /> : <NotThere />;
  return <Known all={all} />;
}

const keyOf = ({ state }: SceneSummary) => state.key;

function Known({ all }: { all: readonly SceneSummary[] }) {
  const { query } = route.value;
  const rows = useMemo(() => filtered(all, query), [all, query]);
  const hasProjects = all.some((row) => sceneOf(row).project !== sceneOf(all[0]!).project);
  const columns = useMemo(() => SCENE_COLUMNS.filter(({ id }) => id !== 'project' || hasProjects), [hasProjects]);
  return (
    <>
      <h1 class="unseen">Overview</h1>
      <div class="summary"><Figures /><Attention /></div>
      <section aria-labelledby="scenes-heading">
        <h2 id="scenes-heading">Scenes</h2>
        {all.length === 0 ? <NoScenes /> : (
          <Table caption="Scenes" csvHref={csvUrl('scenes', { project: route.value.query.get('project') ?? '' })} columns={columns} rows={rows} keyOf={keyOf} sort="-verdict" tools={<Tools all={all} />} />
        )}
        {all.length > 0 && rows.length === 0 && <Empty title="No scene matches the filter" />}
      </section>
      <Projects all={all} />
      <p class="soft small"><SessionCount /> A verdict uses the evidence of all sessions. A scene is changing if its regimes have different best algorithms or its session switches often, and stable if P(best) of its leader is at least {significant(stableProbability.value, 1)}.</p>
      <p class="soft small"><a href={urlOf('/recording')}>Play a recording</a> of the boxes of a game.</p>
      <details class="soft small">
        <summary>Terms on this page</summary>
        <dl>{GLOSSARY.map(([name, meaning]) => [<dt key={name}>{name}</dt>, <dd key={`${name}=`}>{meaning}</dd>])}</dl>
      </details>
    </>
  );
}

// A component of its own, so that changed sessions do not redraw the overview.
const SessionCount = () => <>The page knows {counted(sessions.value.size, 'session', 'sessions')}.</>;

function NotThere() {
  const { error } = connection.value;
  if (error && error.code !== 'UNREACHABLE') return <Failure what="The scenes" error={error} onRetry={() => location.reload()} />;
  return <Empty title="No connection to the daemon"><p>Reason: {error?.message ?? 'the connection was lost'}. The page reconnects automatically.</p></Empty>;
}
