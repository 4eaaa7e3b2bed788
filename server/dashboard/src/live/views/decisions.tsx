// The audit log: the list of sessions with a log, their rows with filters and pages, and an explanation of each row at its own URL.
import { AuditKind, type AuditSegment, AuditService } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { grouped } from '../../format';
import { auditRows, collectPage, type Filter as RowFilter, findRow, type Page, PAGE_ROWS, type PlacedRow, rowId, unixMsOf } from '../audit/log';
import { stepOfRow } from '../audit/steps';
import { Arm } from '../parts/arm';
import { ago, now, timeText } from '../parts/clock';
import { CopyLink } from '../parts/toast';
import { Choice, Filter, matches } from '../parts/filter';
import { addShortcuts } from '../parts/keys';
import { Name, visible } from '../parts/name';
import { Empty, Failure, Loading, Read } from '../parts/states';
import { type Column, Table } from '../parts/table';
import { decisionsHref, route, sessionHref, setQuery } from '../state/route';
import { useList, useReading } from '../transport/reading';
import { explainedRow } from '../audit/explain';
import { Why } from './session/why';
import { kindWord, outcomeWord } from './words';
import { useEffect } from 'preact/hooks';

/** Maximum number of pages. `sweepstake audit export` reads older rows. */
const MAX_PAGE = 100;
const ADMIN = 'admin'; // session id of the rows of administrators; no real session has it

const SEGMENTS: readonly Column<AuditSegment>[] = [
  { id: 'began', title: 'Began', sort: ({ unixStartMs }) => Number(unixStartMs), csv: ({ unixStartMs }) => new Date(Number(unixStartMs)).toISOString(),
    cell: ({ unixStartMs }) => (unixStartMs ? timeText(Number(unixStartMs)) : '–') },
  { id: 'session', title: 'Session', isText: true, sort: ({ sessionId }) => sessionId,
    cell: ({ sessionId }) => <a href={decisionsHref({ session: sessionId })}>{sessionId === ADMIN ? 'administration' : <Name text={sessionId} />}</a> },
  { id: 'scene', title: 'Scene', isText: true, sort: ({ scene }) => scene,
    cell: ({ project, scene }) => (scene ? <a href={decisionsHref({ project, scene })}><Name text={scene} /></a> : '–') },
  { id: 'project', title: 'Project', isText: true, sort: ({ project }) => project, cell: ({ project }) => <Name text={project} unknown="–" /> },
  { id: 'part', title: 'Part', hint: 'A session that continues after a restart of the daemon begins a new part', sort: ({ segment }) => segment },
  { id: 'rows', title: 'Rows', sort: ({ rowCount }) => Number(rowCount) },
  { id: 'removed', title: 'Removed', hint: 'Older rows that were removed because the size of the log is limited', sort: ({ firstRow }) => Math.max(0, Number(firstRow) - 1) },
  { id: 'lost', title: 'Lost', hint: 'Rows that could not be written', sort: ({ lostRowCount }) => Number(lostRowCount) },
];

function SegmentTable({ all, again }: { all: readonly AuditSegment[]; again: () => void }) {
  const text = route.value.query.get('q') ?? '';
  const shown = all.filter(({ sessionId, project, scene }) => matches(text, [sessionId, project, scene]));
  return (
    <>
      <p>The log of a session has a row for every decision and for every event that decisions depend on. Choose a session or a scene.</p>
      <Table caption="Logs" columns={SEGMENTS} rows={shown} keyOf={({ sessionId, segment }) => `${sessionId}\n${segment}`} sort="-began"
        tools={<><Filter label="Search logs" /><button type="button" onClick={again}>Read again</button></>} />
      {shown.length === 0 && <Empty title="No log matches the search" />}
    </>
  );
}

function Segments() {
  const reading = useList(AuditService.method.listAuditSegments, {});
  return (
    <Read reading={reading} what="the list of logs">
      {(parts) => (parts.some(({ segments }) => segments.length > 0)
        ? <SegmentTable all={parts.flatMap(({ segments }) => segments)} again={reading.again} />
        : <Empty title="There are no decisions yet"><p>Each session has a log here after its first decision.</p></Empty>)}
    </Read>
  );
}

/** Returns the time of a row by the daemon's wall clock; undefined if the row has none. */
function timeOf({ row, setup }: PlacedRow): number | undefined {
  if (row.unixMs !== undefined) return Number(row.unixMs);
  return setup && row.timeNs !== undefined ? unixMsOf(setup, row.timeNs) : undefined;
}

const wordsOf = ({ row, setup }: PlacedRow) => visible(explainedRow(row, setup)[0] ?? '');
const outcomeText = ({ row: { decision } }: PlacedRow) => (decision ? outcomeWord(decision.outcome).name : '');
const armOf = ({ row: { arm, decision } }: PlacedRow) => decision?.activeArm || arm;
const candidateOf = ({ row: { decision } }: PlacedRow) => decision?.candidate ?? '';
const rowHref = ({ row }: PlacedRow) => {
  const query = new URLSearchParams(route.value.query);
  query.set('row', rowId(row));
  return `${route.value.path}?${query.toString()}`;
};

const ROWS: readonly Column<PlacedRow>[] = [
  { id: 'time', title: 'Time', sort: timeOf, csv: (placed) => (timeOf(placed) ? new Date(timeOf(placed)!).toISOString() : ''),
    cell: (placed) => <a href={rowHref(placed)}>{timeOf(placed) ? timeText(timeOf(placed)!) : `row ${placed.row.row}`}</a> },
  { id: 'kind', title: 'Kind', isText: true, csv: ({ row }) => AuditKind[row.kind], sort: ({ row }) => kindWord(row.kind).name,
    cell: ({ row }) => <span title={kindWord(row.kind).meaning}><span aria-hidden="true">{kindWord(row.kind).mark} </span>{kindWord(row.kind).name}</span> },
  { id: 'decision', title: 'Decision', sort: ({ row }) => row.decision && Number(row.decision.id), cell: ({ row }) => String(row.decision?.id ?? '–') },
  { id: 'active', title: 'Active algorithm', isText: true, sort: armOf,
    cell: (placed) => (armOf(placed) ? <Arm name={armOf(placed)} /> : '–') },
  { id: 'candidate', title: 'Candidate', isText: true, sort: candidateOf,
    cell: (placed) => (candidateOf(placed) ? <Arm name={candidateOf(placed)} hollow /> : '–') },
  { id: 'outcome', title: 'Outcome', isText: true, sort: outcomeText, cell: (placed) => outcomeText(placed) || '–' },
  { id: 'words', title: 'In words', isText: true, csv: wordsOf, cell: (placed) => <bdi class="words">{wordsOf(placed)}</bdi> },
  { id: 'session', title: 'Session', isText: true, sort: ({ row }) => row.session, cell: ({ row }) => <a href={sessionHref(row.session)}><Name text={row.session} /></a> },
];

interface Asked { session: string; project: string; scene: string; filter: RowFilter; page: number; row: string }

function asked(): Asked {
  const { query } = route.value;
  const text = (name: string) => query.get(name) ?? '';
  return {
    session: text('session'), project: text('project'), scene: text('scene'), filter: { kind: text('kind'), outcome: text('outcome'), arm: text('arm') },
    page: Math.min(Math.max(Math.floor(Number(text('page')) || 0), 0), MAX_PAGE - 1), row: text('row'),
  };
}

function OneRow({ session, row }: { session: string; row: string }) {
  const close = () => setQuery({ row: undefined });
  useEffect(() => addShortcuts([{ keys: 'Escape', what: 'Close the explanation', run: close }]), []);
  const reading = useReading(row, (cancel) => findRow(auditRows({ sessionId: session }, cancel), row));
  const missing = <Empty title="The log does not have this row"><p>The row was removed because the size of the log is limited, or it never existed.</p></Empty>;
  const shown = (placed: PlacedRow) => {
    const step = stepOfRow(placed);
    return step
      ? <Why step={step} sessionId={session} onRead={reading.again} onClose={close} />
      : <p class="why">{explainedRow(placed.row, placed.setup).map((sentence) => <bdi key={sentence}>{visible(sentence)}</bdi>)} <button type="button" class="quiet" onClick={close}>Close</button></p>;
  };
  return <Read reading={reading} what="the row">{(placed) => (placed ? shown(placed) : missing)}</Read>;
}

function Pager({ page, matchCount, order }: { page: number; matchCount: number; order: string }) {
  const first = page * PAGE_ROWS + 1;
  const last = Math.min((page + 1) * PAGE_ROWS, matchCount);
  const go = (to: number) => setQuery({ page: to > 0 ? String(to) : undefined }, { step: true });
  return (
    <nav class="orders" aria-label="Pages">
      <button type="button" disabled={page === 0} onClick={() => go(page - 1)}>Newer</button>
      <span>{matchCount === 0 ? 'none' : `${grouped(first)} to ${grouped(last)} of ${grouped(matchCount)}, ${order}`}</span>
      <button type="button" disabled={last >= matchCount || page + 1 >= MAX_PAGE} onClick={() => go(page + 1)}>Older</button>
      {page + 1 >= MAX_PAGE && <span class="soft"><code>sweepstake audit export</code> writes older rows, too.</span>}
    </nav>
  );
}

// The choices of an enumeration, by the names of its values.
const choicesOf = <Value extends number>(names: Readonly<Record<string, string | number>>, wordOf: (value: Value) => { name: string }) =>
  [['', 'any'], ...Object.entries(names).filter(([, value]) => Number(value) > 0)
    .map(([name, value]) => [name, wordOf(value as Value).name] as const)] as const;
const KINDS = choicesOf<AuditKind>(AuditKind, kindWord);
const OUTCOMES = choicesOf<DecisionOutcome>(DecisionOutcome, outcomeWord);

function Rows({ session, project, scene, filter, page }: Asked) {
  const selection = { sessionId: session, project, scene };
  const { value, error, isReading, atMs, again } = useReading<Page>(JSON.stringify([selection, filter, page]),
    (cancel, show) => collectPage(auditRows(selection, cancel), filter, page, show));
  const found = isReading || error ? undefined : value;
  const arms = [...new Set((found?.rows ?? []).flatMap(({ setup }) => setup?.arms ?? []).concat(filter.arm || []))].sort();
  return (
    <>
      <div class="tools">
        <Choice label="Kind" parameter="kind" options={KINDS} />
        <Choice label="Outcome" parameter="outcome" options={OUTCOMES} />
        <Choice label="Algorithm" parameter="arm" options={[['', 'any'], ...arms.map((arm) => [arm, visible(arm)] as const)]} />
        <button type="button" onClick={again} disabled={isReading}>Read again</button>
        {found && <span class="soft">read {ago(atMs, now.value)}</span>}
      </div>
      {error && <Failure what="the log" error={error} onRetry={again} />}
      {isReading && <Loading what={value ? `the log, ${grouped(value.rowCount)} rows so far` : 'the log'} />}
      {found && <Pager page={page} matchCount={found.matchCount} order={session ? 'newest first' : 'the newest logs first'} />}
      {found && found.rows.length > 0 && <Table caption="Rows" columns={ROWS} rows={found.rows} keyOf={({ row }) => rowId(row)} sort="-time" sortParameter="rows" />}
      {found?.rows.length === 0 && <Empty title={found.rowCount === 0 ? 'There is no log for this selection' : 'No row matches the filter'} />}
    </>
  );
}

function Heading({ session, project, scene }: Asked) {
  if (session === ADMIN) return <>Administration</>;
  if (session) return <>Decisions of session <a href={sessionHref(session)}><Name text={session} /></a></>;
  return scene ? <>Decisions in <Name text={scene} /></> : <>Decisions of <Name text={project} /></>;
}

export function DecisionsView() {
  const all = asked();
  const isChosen = Boolean(all.session || all.project || all.scene);
  const rowSession = all.session || all.row.split('.').slice(0, -2).join('.');
  return (
    <>
      <header class="title"><h1>{isChosen ? <Heading {...all} /> : 'Decisions'}</h1><CopyLink /></header>
      {isChosen && <p><a href={decisionsHref({})}>All logs</a></p>}
      {all.row && <OneRow key={all.row} session={rowSession} row={all.row} />}
      {isChosen ? <Rows {...all} /> : <Segments />}
    </>
  );
}
