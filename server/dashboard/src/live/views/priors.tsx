// The stored evidence by build, scene, arm and source; the comparison of two builds; the download of a priors file; promotion and
// revocation.
import { type PriorRecord, PriorsService } from '../../gen/sweepstake/v1/priors_pb';
import { grouped, significant } from '../../format';
import { ago, now, timeText } from '../parts/clock';
import { CopyLink } from '../parts/toast';
import { csvUrl, download } from '../parts/download';
import { Choice, Filter, matches } from '../parts/filter';
import { fileName, Name, visible } from '../parts/name';
import { Empty, Failure, Loading } from '../parts/states';
import { type Group, groupsOf, MAX_RECORDS, priorsFile, mostOf, namesOf, sumOf } from '../state/evidence';
import { scenes } from '../state/scenes';
import { type ApiError, asApiError, stream } from '../transport/calls';
import { useReading } from '../transport/reading';
import { Changes } from './priors/changes';
import { OperatorReason, PriorsQuestion, PromoteButton, RevokeButton } from './priors/question';
import { useMemo } from 'preact/hooks';
import { Arm } from '../parts/arm';
import { type Column, Table, type TableProps } from '../parts/table';
import { decisionsHref, route, sceneHref, sessionHref } from '../state/route';
import { sessions } from '../state/sessions';

interface Evidence {
  used: readonly PriorRecord[];
  waiting: readonly PriorRecord[]; // in quarantine
  isCut: boolean; // there are more than MAX_RECORDS records
  error?: ApiError; // the evidence received before the error is shown
}

async function read(project: string, cancel: AbortSignal): Promise<Evidence> {
  const records: PriorRecord[] = [];
  const evidence = () => ({
    used: records.filter(({ isQuarantined }) => !isQuarantined).slice(0, MAX_RECORDS),
    waiting: records.filter(({ isQuarantined }) => isQuarantined).slice(0, MAX_RECORDS),
    isCut: records.length > MAX_RECORDS,
  });
  try {
    for await (const part of stream(PriorsService.method.exportPriors, { project, withWeights: true }, cancel)) {
      if (records.length <= MAX_RECORDS) records.push(...part.records);
    }
    return evidence();
  } catch (error) {
    return { ...evidence(), error: asApiError(error) };
  }
}

function Notes({ used, isCut, project }: Evidence & { project: string }) {
  return (
    <p class="soft small">
      {grouped(used.length)} records of {grouped(new Set(used.map(({ sourceId }) => sourceId)).size)} sources
      {project && <> of <Name text={project} /></>}.
      {isCut && ` There are more records. The tables and the file leave them out${project ? '' : '; choose a project to see all of its records'}.`}
    </p>
  );
}

// The section of evidence in quarantine. It comes first on the page, because an operator has to promote or revoke it.
function Quarantine({ waiting, scope }: { waiting: readonly PriorRecord[]; scope: { project?: string } }) {
  return (
    <section>
      <h2>Waiting in quarantine</h2>
      <p>{grouped(waiting.length)} imported records have no effect until an operator promotes them. No session starts from them, and no posterior includes them.</p>
      <div class="tools"><PromoteButton scope={scope} /></div>
      <Groups records={waiting} by={BY_BUILD} columns={WAITING} caption="Quarantine" sort="build" sortParameter="waiting" />
    </section>
  );
}

const Tables = ({ records, project }: { records: readonly PriorRecord[]; project: string }) => (
  <>
    <section><h2>Builds</h2><Groups records={records} by={BY_BUILD} columns={BUILDS} caption="Builds" sort="-seen" sortParameter="builds" /></section>
    <section><h2>From build to build</h2><Changes known={buildsOf(records)} project={project} /></section>
    <section><h2>Evidence</h2><Groups records={records} by={BY_ARM} columns={SUMS} caption="Sums of evidence" sort="scene" csvHref={csvUrl('evidence', { project, withWeights: true })} /></section>
    <section><h2>Sources</h2><Groups records={records} by={['sourceId']} columns={SOURCES} caption="Sources" sort="-windows" sortParameter="sources" /></section>
  </>
);

const buildsOf = (records: readonly PriorRecord[]) => groupsOf(records, 'build').sort((a, b) => lastSeenS(b) - lastSeenS(a)).map(({ example }) => example.build);

const namesIn = (records: readonly PriorRecord[], field: 'build' | 'project') => [...new Set(records.map((record) => record[field]))];

const save = (records: readonly PriorRecord[], project: string) =>
  download(`${fileName('sweepstake', project, 'priors')}.json`, priorsFile(records), 'application/json');

export function Priors() {
  const project = route.value.query.get('project') ?? '';
  const { value: evidence, isReading, atMs, again } = useReading(project, (cancel) => read(project, cancel));
  const { used = [], waiting = [], error } = evidence ?? {};
  const records = [...used, ...waiting];
  const scope = project ? { project } : {};
  const projects = [...new Set([...[...scenes.value.values()].map(({ posterior }) => posterior.project), ...namesIn(records, 'project')])].sort();
  return (
    <>
      <header class="title"><h1>Priors</h1><CopyLink /></header>
      <p>New sessions start from this stored evidence. Its figures do not include the prior Beta(1,1). The views of scenes also include the newest evidence of their sessions, which may not be stored yet.</p>
      <div class="tools">
        <Filter label="Search evidence" />
        <Choice label="Project" parameter="project" options={[['', 'all'], ...projects.map((each) => [each, visible(each)] as const)]} />
        <button type="button" onClick={again} disabled={isReading}>Read again</button>
        <button type="button" disabled={records.length === 0} onClick={() => save(records, project)}
          title="The file that `sweepstake priors import` and a shipped game read">Download</button>
        <RevokeButton scope={scope} />
        <OperatorReason />
        {evidence && !error && <span class="soft">read {ago(atMs, now.value)}</span>}
      </div>
      <PriorsQuestion known={{ projects, builds: namesIn(used, 'build').filter(Boolean).sort() }} onDone={again} />
      {isReading && <Loading what="the evidence" />}
      {error && <Failure what="the complete evidence" error={error} onRetry={again} />}
      {waiting.length > 0 && <Quarantine waiting={waiting} scope={scope} />}
      {evidence && !error && used.length === 0 && <Empty title="Nothing is stored yet"><p>The evidence of a session is stored while the session continues. It appears here a moment later.</p></Empty>}
      {used.length > 0 && <><Notes {...evidence!} project={project} /><Tables records={used} project={project} /></>}
      <p class="soft small"><code>sweepstake priors import --daemon HOST:PORT --in FILE</code> imports a file of priors. The imported evidence waits here until an operator promotes it.</p>
    </>
  );
}

const LANE = 'lane'; // the value of measured_by for evidence from the shadow lane; '' stands for the frame thread

const [sourcesOf, scenesOf, armsOf, classesOf] = [namesOf('sourceId'), namesOf('scene'), namesOf('arm'), namesOf('machineClass')];
const [alphaOf, betaOf, weightOf, lastSeenS] = [sumOf('alphaIncrement'), sumOf('betaIncrement'), mostOf('weight'), mostOf('unixLastSeenS')];
const NUMBERS: readonly Column<Group>[] = [
  { id: 'windows', title: 'Windows', hint: 'Decision windows, and visits of the shadow lane', sort: sumOf('windowCount') },
  { id: 'bails', title: 'Bail-outs', sort: sumOf('bailOutCount') },
];
const BUILD: Column<Group> = { id: 'build', title: 'Build', isText: true, sort: ({ example }) => example.build };
const SOURCE_COUNT: Column<Group> = { id: 'sources', title: 'Sources', hint: 'Sessions and imported sources', sort: (row) => sourcesOf(row).length };
const PROJECT: Column<Group> = { id: 'project', title: 'Project', isText: true, sort: ({ example }) => example.project };

const ORIGIN: readonly Column<Group>[] = [
  ...NUMBERS,
  { id: 'arms', title: 'Algorithms', sort: (row) => armsOf(row).length },
  { id: 'seen', title: 'Last seen', hint: 'Time of its latest evidence, by the clock of its daemon', sort: (row) => lastSeenS(row) || undefined,
    cell: (row) => (lastSeenS(row) ? timeText(1000 * lastSeenS(row)) : '–') },
  { id: 'classes', title: 'Machines', isText: true, sort: (row) => classesOf(row).join(', ') },
  { id: 'scenes', title: 'Scenes', isText: true, sort: (row) => scenesOf(row).join(', ') },
  PROJECT,
];

const buildsWith = (title: string, Button: typeof RevokeButton): readonly Column<Group>[] => [
  BUILD,
  { id: title.toLowerCase(), title, isText: true, cell: ({ example: { project, build } }) => build && <Button scope={{ project, build }} of={`build ${build}`} /> },
  SOURCE_COUNT, ...ORIGIN,
];
const BUILDS = buildsWith('Revoke', RevokeButton);
const WAITING = buildsWith('Promote', PromoteButton);

// A session that has left the daemon's memory is shown by its rows in the audit log.
const sourceHref = (id: string) => (sessions.value.has(id) ? sessionHref(id) : decisionsHref({ session: id }));

const SOURCES: readonly Column<Group>[] = [
  { id: 'source', title: 'Source', sort: ({ key }) => key,
    cell: ({ key, example: { isImported } }) => (isImported ? <Name text={key} /> : <a href={sourceHref(key)}><Name text={key} /></a>) },
  { id: 'revoke', title: 'Revoke', isText: true,
    cell: ({ example: { project, sourceId } }) => <RevokeButton scope={{ project, sourceId }} of={`source ${sourceId}`} /> },
  { id: 'origin', title: 'Origin', isText: true, hint: 'A session of this daemon, or the import of a file of priors',
    sort: ({ example }) => (example.isImported ? 'import' : 'session') },
  BUILD,
  { id: 'weight', title: 'Weight', hint: 'The highest weight of its records in a new session. That session runs on the same class of machines, with the latest build of the scene and '
    + 'the newest backends. 0: newer sources of every algorithm have replaced it. 1: rewards do not depend on the cost alone, so the chosen sources count fully',
    sort: weightOf, cell: (row) => significant(weightOf(row)) },
  ...ORIGIN,
];

const meanOf = (row: Group) => (alphaOf(row) + betaOf(row) > 0 ? alphaOf(row) / (alphaOf(row) + betaOf(row)) : undefined);

const SUMS: readonly Column<Group>[] = [
  { id: 'scene', title: 'Scene', sort: ({ example }) => `${example.project}\n${example.scene}`,
    cell: ({ example }) => <a href={sceneHref(example)}><Name text={example.scene} /></a> },
  { id: 'arm', title: 'Algorithm', isText: true, sort: ({ example }) => example.arm,
    cell: ({ example }) => <Arm name={example.arm} hollow={example.measuredBy === LANE} /> },
  { id: 'by', title: 'Measured', isText: true, hint: 'On the frame thread of games, or beside it in the shadow lane',
    sort: ({ example }) => (example.measuredBy === LANE ? 'shadow lane' : 'live') },
  BUILD,
  { id: 'backend', title: 'Version', hint: 'Version of the backend’s code; evidence of different versions is kept apart', sort: ({ example }) => example.backendVersion },
  SOURCE_COUNT, ...NUMBERS,
  { id: 'mean', title: 'Mean reward', hint: 'α ÷ (α + β) of this evidence, without any prior', sort: meanOf, cell: (row) => meanOf(row)?.toFixed(4) ?? '–' },
  { id: 'alpha', title: 'α', hint: 'What this evidence adds to α of the Beta distribution', sort: alphaOf, cell: (row) => significant(alphaOf(row), 4) },
  { id: 'beta', title: 'β', hint: 'What this evidence adds to β of the Beta distribution', sort: betaOf, cell: (row) => significant(betaOf(row), 4) },
  PROJECT,
  { id: 'class', title: 'Machines', isText: true, sort: ({ example }) => example.machineClass },
  { id: 'reward', title: 'Reward', sort: ({ example }) => example.rewardVersion },
];

interface GroupsProps extends Omit<TableProps<Group>, 'rows' | 'keyOf'> { records: readonly PriorRecord[]; by: readonly (keyof PriorRecord)[] }

function Groups({ records, by, ...table }: GroupsProps) {
  const groups = useMemo(() => groupsOf(records, ...by), [records]);
  const filter = route.value.query.get('q') ?? '';
  const rows = groups.filter((group) => matches(filter, [group.key, ...scenesOf(group), ...armsOf(group), ...classesOf(group)]));
  return <Table {...table} rows={rows} keyOf={({ key }) => key} />;
}

const BY_BUILD = ['project', 'build'] as const;
const BY_ARM = [...BY_BUILD, 'scene', 'machineClass', 'rewardVersion', 'arm', 'backendVersion', 'measuredBy'] as const;
