// The stored evidence by build, scene, arm and source; the comparison of two builds; the download of a priors file; promotion and
// revocation.
import { useEffect, useState } from 'preact/hooks';
import { PriorsService } from '../../gen/sweepstake/v1/priors_pb';
import { grouped } from '../../format';
import { ago, now } from '../parts/clock';
import { CopyLink } from '../parts/copy_link';
import { download } from '../parts/download';
import { Choice, Filter } from '../parts/filter';
import { Name } from '../parts/name';
import { Empty, Failure, Loading } from '../parts/states';
import { fileName, visible } from '../parts/visible';
import { addPart, noEvidence, priorsFile, type Evidence } from '../state/evidence';
import { route } from '../state/route';
import { scenes } from '../state/scenes';
import { asApiError, stream, type ApiError } from '../transport/calls';
import { Changes } from './priors/changes';
import { OperatorReason, PromoteButton, PriorsQuestion, RevokeButton } from './priors/question';
import { Builds, Sources, Sums, Waiting } from './priors/tables';

interface Answer {
  evidence: Evidence;
  isWhole: boolean;
  atMs: number;
  error?: ApiError;
}

// Reads all evidence of a project, or of all projects. If the call fails, the evidence received so far is shown.
async function read(project: string, cancel: AbortSignal, show: (answer: Answer) => void): Promise<void> {
  const evidence = noEvidence();
  let isWhole = false;
  try {
    for await (const part of stream(PriorsService.method.exportPriors, { project, withWeights: true }, cancel)) {
      addPart(evidence, part);
    }
    isWhole = true;
    show({ evidence, isWhole, atMs: Date.now() });
  } catch (error) {
    if (!cancel.aborted) show({ evidence, isWhole, atMs: Date.now(), error: asApiError(error) });
  }
}

function useEvidence(project: string): { answer: Answer | undefined; again(): void } {
  const [answer, setAnswer] = useState<Answer | undefined>(undefined);
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const cancel = new AbortController();
    setAnswer(undefined);
    void read(project, cancel.signal, setAnswer);
    return () => cancel.abort();
  }, [project, turn]);
  return { answer, again: () => setTurn(turn + 1) };
}

function Notes({ evidence, project }: { evidence: Evidence; project: string }) {
  return (
    <p class="soft small">
      {grouped(evidence.recordCount)} records of {grouped(evidence.sources.size)} sources
      {project && <> of <Name text={project} /></>}.
      {evidence.isCut && ' Not all of them are in the tables and in the file; choose a project.'}
    </p>
  );
}

// It stands on top, because it needs an action.
function Quarantine({ evidence, project }: { evidence: Evidence; project: string }) {
  return (
    <section>
      <h2>Waiting in quarantine</h2>
      <p>{grouped(evidence.waitingCount)} imported records count nowhere until an operator promotes them: no session begins with them, and no posterior has them.</p>
      <div class="tools"><PromoteButton scope={project ? { project } : {}} /></div>
      <Waiting evidence={evidence} />
    </section>
  );
}

function Tables({ evidence, project }: { evidence: Evidence; project: string }) {
  return (
    <>
      <section><h2>Builds</h2><Builds evidence={evidence} /></section>
      <section><h2>From build to build</h2><Changes evidence={evidence} project={project} /></section>
      <section><h2>Evidence</h2><Sums evidence={evidence} /></section>
      <section><h2>Sources</h2><Sources evidence={evidence} /></section>
    </>
  );
}

const save = ({ records }: Evidence, project: string) =>
  download(`${fileName('sweepstake', project, 'priors')}.json`, priorsFile(records), 'application/json');

function projectsOf(evidence: Evidence | undefined): string[] {
  const known = [...scenes.value.values()].map(({ posterior }) => posterior.project);
  const taught = [...evidence?.builds.values() ?? [], ...evidence?.waiting.values() ?? []];
  return [...new Set([...known, ...taught.map(({ project }) => project)])].sort();
}

export function Priors() {
  const project = route.value.query.get('project') ?? '';
  const { answer, again } = useEvidence(project);
  const evidence = answer?.evidence;
  const projects = projectsOf(evidence);
  const builds = [...new Set([...evidence?.builds.values() ?? []].map(({ build }) => build).filter(Boolean))].sort();
  return (
    <>
      <header class="title"><h1>Priors</h1><CopyLink /></header>
      <p>What new sessions start from: all evidence that is stored, without the prior Beta(1,1). Live scenes show it together with what their sessions learn.</p>
      <div class="tools">
        <Filter label="Search evidence" />
        <Choice label="Project" parameter="project" options={[['', 'all'], ...projects.map((each) => [each, visible(each)] as const)]} />
        <button type="button" onClick={again} disabled={!answer}>Read again</button>
        <button type="button" disabled={!evidence?.records.length} onClick={() => evidence && save(evidence, project)}
          title="The file that `sweepstake priors import` and a shipped game read">Download</button>
        <RevokeButton scope={project ? { project } : {}} />
        <OperatorReason />
        {answer?.isWhole && <span class="soft">read {ago(answer.atMs, now.value)}</span>}
      </div>
      <PriorsQuestion known={{ projects, builds }} onDone={again} />
      {!answer && <Loading what="the evidence" />}
      {answer?.error && <Failure what="All of the evidence" error={answer.error} onRetry={again} />}
      {evidence && evidence.waitingCount > 0 && <Quarantine evidence={evidence} project={project} />}
      {answer?.isWhole && answer.evidence.recordCount === 0 && <Empty title="Nothing is stored yet"><p>Sessions’ evidence is written as they go on; it appears here a moment later.</p></Empty>}
      {evidence && evidence.recordCount > 0 && <><Notes evidence={evidence} project={project} /><Tables evidence={evidence} project={project} /></>}
      <p class="soft small">A file of priors comes in by <code>sweepstake priors import --daemon HOST:PORT --in FILE</code>, and waits here.</p>
    </>
  );
}
