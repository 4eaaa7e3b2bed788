// The stored evidence by build, scene, arm and source; the comparison of two builds; the download of a priors file; promotion and
// revocation.
import { type PriorRecord, PriorsService } from '../../gen/sweepstake/v1/priors_pb';
import { grouped } from '../../format';
import { ago, now } from '../parts/clock';
import { CopyLink } from '../parts/toast';
import { download } from '../parts/download';
import { Choice, Filter } from '../parts/filter';
import { Name } from '../parts/name';
import { Empty, Failure, Loading } from '../parts/states';
import { fileName, visible } from '../parts/visible';
import { MAX_RECORDS, priorsFile } from '../state/evidence';
import { route } from '../state/route';
import { scenes } from '../state/scenes';
import { type ApiError, asApiError, stream } from '../transport/calls';
import { useReading } from '../transport/reading';
import { Changes } from './priors/changes';
import { OperatorReason, PromoteButton, PriorsQuestion, RevokeButton } from './priors/question';
import { Builds, Sources, Sums, Waiting } from './priors/tables';

interface Evidence {
  used: readonly PriorRecord[];
  waiting: readonly PriorRecord[]; // in quarantine
  isCut: boolean; // there are more than MAX_RECORDS records
  error?: ApiError; // the evidence received before the error is shown
}

// Reads the evidence of a project, or of all projects.
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
      {isCut && ' Not all of them are in the tables and in the file; choose a project.'}
    </p>
  );
}

// It is the first section, because it needs an action.
function Quarantine({ waiting, scope }: { waiting: readonly PriorRecord[]; scope: { project?: string } }) {
  return (
    <section>
      <h2>Waiting in quarantine</h2>
      <p>{grouped(waiting.length)} imported records have no effect until an operator promotes them. No session starts from them, and no posterior includes them.</p>
      <div class="tools"><PromoteButton scope={scope} /></div>
      <Waiting records={waiting} />
    </section>
  );
}

function Tables({ records, project }: { records: readonly PriorRecord[]; project: string }) {
  return (
    <>
      <section><h2>Builds</h2><Builds records={records} /></section>
      <section><h2>From build to build</h2><Changes known={namesIn(records, 'build')} project={project} /></section>
      <section><h2>Evidence</h2><Sums records={records} /></section>
      <section><h2>Sources</h2><Sources records={records} /></section>
    </>
  );
}

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
      <p>New sessions start from this evidence: everything that is stored, without the prior Beta(1,1). The views of scenes also include the newest evidence of their sessions.</p>
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
      {error && <Failure what="all of the evidence" error={error} onRetry={again} />}
      {waiting.length > 0 && <Quarantine waiting={waiting} scope={scope} />}
      {evidence && !error && used.length === 0 && <Empty title="Nothing is stored yet"><p>The evidence of a session is stored while the session continues. It appears here a moment later.</p></Empty>}
      {used.length > 0 && <><Notes {...evidence!} project={project} /><Tables records={used} project={project} /></>}
      <p class="soft small"><code>sweepstake priors import --daemon HOST:PORT --in FILE</code> imports a file of priors. The imported evidence waits here for its promotion.</p>
    </>
  );
}
