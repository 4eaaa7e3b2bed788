// What the daemon has learnt, scene by scene and arm by arm, which sources it has it from, and a file of it to take along.
import { useEffect, useState } from 'preact/hooks';
import { PriorsService } from '../../gen/sweepstake/v1/priors_pb';
import { grouped, significant } from '../../format';
import { Arm } from '../parts/arm';
import { ago, now } from '../parts/clock';
import { CopyLink } from '../parts/copy_link';
import { download } from '../parts/download';
import { Choice, Filter, matches } from '../parts/filter';
import { Name } from '../parts/name';
import { Empty, Failure, Loading } from '../parts/states';
import { Table, type Column } from '../parts/table';
import { fileName, visible } from '../parts/visible';
import { addPart, MAX_KEPT_RECORDS, MAX_SOURCES, noEvidence, priorsFile, type Evidence, type EvidenceSum, type SourceSum } from '../state/evidence';
import { decisionsHref, route, sceneHref, sessionHref } from '../state/route';
import { scenes } from '../state/scenes';
import { sessions } from '../state/sessions';
import { asApiError, stream, type ApiError } from '../transport/calls';

const LANE = 'lane';

const SUMS: readonly Column<EvidenceSum>[] = [
  { id: 'scene', title: 'Scene', sort: ({ example }) => `${example.project}\n${example.scene}`, csv: ({ example }) => example.scene,
    cell: ({ example }) => <a href={sceneHref(example)}><Name text={example.scene} /></a> },
  { id: 'arm', title: 'Arm', isText: true, sort: ({ example }) => example.arm, cell: ({ example }) => <Arm name={example.arm} hollow={example.measuredBy === LANE} /> },
  { id: 'by', title: 'Measured', isText: true, hint: 'On the frame thread of games, or beside it in the shadow lane', sort: ({ example }) => example.measuredBy,
    csv: ({ example }) => example.measuredBy || 'live', cell: ({ example }) => (example.measuredBy === LANE ? 'shadow lane' : 'live') },
  { id: 'backend', title: 'Version', hint: 'Version of the backend’s code; evidence of different versions is kept apart', sort: ({ example }) => example.backendVersion,
    cell: ({ example }) => example.backendVersion },
  { id: 'sources', title: 'Sources', hint: 'Sessions that measured it', sort: (row) => row.sourceCount, cell: (row) => grouped(row.sourceCount) },
  { id: 'windows', title: 'Windows', hint: 'Decision windows, or visits of the lane', sort: (row) => row.windowCount, cell: (row) => grouped(row.windowCount) },
  { id: 'bails', title: 'Bail-outs', sort: (row) => row.bailOutCount, cell: (row) => grouped(row.bailOutCount) },
  { id: 'mean', title: 'Mean reward', hint: 'α ÷ (α + β) of the evidence alone', sort: ({ alpha, beta }) => (alpha + beta > 0 ? alpha / (alpha + beta) : undefined),
    cell: ({ alpha, beta }) => (alpha + beta > 0 ? (alpha / (alpha + beta)).toFixed(4) : '–') },
  { id: 'alpha', title: 'α', hint: 'Successes, without any prior', sort: (row) => row.alpha, cell: (row) => significant(row.alpha, 4) },
  { id: 'beta', title: 'β', hint: 'Failures, without any prior', sort: (row) => row.beta, cell: (row) => significant(row.beta, 4) },
  { id: 'project', title: 'Project', isText: true, sort: ({ example }) => example.project, cell: ({ example }) => <Name text={example.project} /> },
  { id: 'class', title: 'Machines', isText: true, sort: ({ example }) => example.machineClass, cell: ({ example }) => <Name text={example.machineClass} /> },
  { id: 'reward', title: 'Reward', sort: ({ example }) => example.rewardVersion, cell: ({ example }) => example.rewardVersion },
];

const buildOf = (id: string) => sessions.value.get(id)?.info.build ?? '';

// A session that is not in memory any more has rows in the audit log.
const sourceHref = (id: string) => (sessions.value.has(id) ? sessionHref(id) : decisionsHref({ session: id }));

const SOURCES: readonly Column<SourceSum>[] = [
  { id: 'source', title: 'Source', sort: ({ sourceId }) => sourceId, cell: ({ sourceId }) => <a href={sourceHref(sourceId)}><Name text={sourceId} /></a> },
  { id: 'build', title: 'Build', isText: true, hint: 'Known of sessions that the daemon has in memory', sort: ({ sourceId }) => buildOf(sourceId), cell: ({ sourceId }) => <Name text={buildOf(sourceId)} /> },
  { id: 'windows', title: 'Windows', hint: 'Windows and visits', sort: (row) => row.windowCount, cell: (row) => grouped(row.windowCount) },
  { id: 'bails', title: 'Bail-outs', sort: (row) => row.bailOutCount, cell: (row) => grouped(row.bailOutCount) },
  { id: 'arms', title: 'Arms', sort: (row) => row.arms.size, cell: (row) => grouped(row.arms.size) },
  { id: 'scenes', title: 'Scenes', isText: true, sort: (row) => [...row.scenes].join(', '), cell: (row) => <Name text={[...row.scenes].join(', ')} /> },
  { id: 'project', title: 'Project', isText: true, sort: (row) => row.project, cell: (row) => <Name text={row.project} /> },
];

interface Answer {
  evidence: Evidence;
  isWhole: boolean;
  atMs: number;
  error?: ApiError;
}

// Reads all evidence of a project, or of all of them. What breaks off is shown as far as it came.
async function read(project: string, cancel: AbortSignal, show: (answer: Answer) => void): Promise<void> {
  const evidence = noEvidence();
  try {
    for await (const part of stream(PriorsService.method.exportPriors, { project }, cancel)) {
      addPart(evidence, part);
    }
    show({ evidence, isWhole: true, atMs: Date.now() });
  } catch (error) {
    if (!cancel.aborted) show({ evidence, isWhole: false, atMs: Date.now(), error: asApiError(error) });
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
  const isCut = evidence.recordCount > MAX_KEPT_RECORDS || evidence.sources.size >= MAX_SOURCES;
  return (
    <p class="soft small">
      {grouped(evidence.recordCount)} records of {grouped(evidence.sources.size)} sources
      {project && <> of <Name text={project} /></>}.
      {evidence.foldedRecordCount > 0 && ` ${grouped(evidence.foldedRecordCount)} more, with ${grouped(evidence.foldedWindowCount)} windows, are of old sessions that the daemon has folded together.`}
      {isCut && ' Not all of them are in the list of sources and in the file; choose a project.'}
    </p>
  );
}

function Tables({ evidence }: { evidence: Evidence }) {
  const filter = route.value.query.get('q') ?? '';
  const sums = [...evidence.sums.values()].filter(({ example }) => matches(filter, [example.project, example.scene, example.arm, example.machineClass]));
  const sources = [...evidence.sources.values()].filter(({ sourceId, project, scenes: names }) => matches(filter, [sourceId, project, ...names, buildOf(sourceId)]));
  return (
    <>
      <section aria-labelledby="evidence-heading">
        <h2 id="evidence-heading">Evidence</h2>
        <Table caption="Sums of evidence" columns={SUMS} rows={sums} keyOf={({ key }) => key} sort="scene" />
      </section>
      <section aria-labelledby="sources-heading">
        <h2 id="sources-heading">Sources</h2>
        <Table caption="Sources" columns={SOURCES} rows={sources} keyOf={({ sourceId }) => sourceId} sort="-windows" sortParameter="sources" />
      </section>
    </>
  );
}

const save = ({ records }: Evidence, project: string) =>
  download(`${fileName('sweepstake', project, 'priors')}.json`, priorsFile(records), 'application/json');

export function Priors() {
  const project = route.value.query.get('project') ?? '';
  const { answer, again } = useEvidence(project);
  const projects = [...new Set([...scenes.value.values()].map(({ posterior }) => posterior.project))].sort();
  return (
    <>
      <header class="title"><h1>Priors</h1><CopyLink /></header>
      <p>What new sessions start from: all evidence that is stored, without the prior Beta(1,1). Live scenes show it together with what their sessions learn.</p>
      <div class="tools">
        <Filter label="Search evidence" />
        <Choice label="Project" parameter="project" options={[['', 'all'], ...projects.map((each) => [each, visible(each)] as const)]} />
        <button type="button" onClick={again} disabled={!answer}>Read again</button>
        <button type="button" disabled={!answer || answer.evidence.recordCount === 0} onClick={() => answer && save(answer.evidence, project)}
          title="The file that `sweepstake priors import` and a shipped game read">Download</button>
        {answer?.isWhole && <span class="soft">read {ago(answer.atMs, now.value)}</span>}
      </div>
      {!answer && <Loading what="the evidence" />}
      {answer?.error && <Failure what="All of the evidence" error={answer.error} onRetry={again} />}
      {answer?.isWhole && answer.evidence.recordCount === 0 && <Empty title="Nothing is stored yet"><p>Sessions’ evidence is written as they go on; it appears here a moment later.</p></Empty>}
      {answer && answer.evidence.recordCount > 0 && <><Notes evidence={answer.evidence} project={project} /><Tables evidence={answer.evidence} /></>}
    </>
  );
}
