// The audit log: the rows of all sessions, of a scene or of a session, with filters, pages and new rows as they arrive; an explanation of
// each row at its own URL; and the list of sessions with a log.
import { AuditKind, type AuditSegment, AuditService, DecisionFilterSchema } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { type LogPart, PAGE_ROWS, type PlacedRow, readRow, readRows, rowId, type Selection, unixMsOf } from '../audit/log';
import { stepOfRow } from '../audit/steps';
import { useLog } from '../audit/use_log';
import { PauseButton } from '../charts/time_chart';
import { pausedMs } from '../charts/view_state';
import { Arm } from '../parts/arm';
import { ago, now, timeText } from '../parts/clock';
import { csvUrl } from '../parts/download';
import { CopyLink } from '../parts/toast';
import { Choice, Filter, matches, TimeChoice } from '../parts/filter';
import { addShortcuts } from '../parts/keys';
import { Name, visible } from '../parts/name';
import { Empty, Failure, Loading, Read } from '../parts/states';
import { type Column, Table } from '../parts/table';
import { decisionsHref, hrefWith, route, sessionHref, setQuery } from '../state/route';
import { scenes } from '../state/scenes';
import { sessions } from '../state/sessions';
import { create, toJson } from '../transport/messages';
import { useList, useReading } from '../transport/reading';
import { explainedRow } from '../audit/explain';
import { Why } from './session/why';
import { kindWord, outcomeWord } from './words';
import { useEffect } from 'preact/hooks';

/** The number of rows above which the first page is read again instead of extended. */
const MAX_ROWS = 5 * PAGE_ROWS;
/** Delay of reading new rows after a decision of any session. */
const READ_AFTER_MS = 1000;
const ADMIN = 'admin'; // session id of the rows of administrators; no real session has it

const SEGMENTS: readonly Column<AuditSegment>[] = [
  { id: 'began', title: 'Began', sort: ({ unixStartMs }) => Number(unixStartMs),
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
      <Table caption="Logs" csvHref={csvUrl('logs')} columns={SEGMENTS} rows={shown} keyOf={({ sessionId, segment }) => `${sessionId}\n${segment}`} sort="-began"
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

function timeOf({ row, setup }: PlacedRow): number | undefined {
  if (row.unixMs !== undefined) return Number(row.unixMs);
  return setup && row.timeNs !== undefined ? unixMsOf(setup, row.timeNs) : undefined;
}

const wordsOf = ({ row, setup }: PlacedRow) => visible(explainedRow(row, setup)[0] ?? '');
const outcomeText = ({ row: { decision } }: PlacedRow) => (decision ? outcomeWord(decision.outcome).name : '');
const armOf = ({ row: { arm, decision } }: PlacedRow) => decision?.activeArm || arm;
const candidateOf = ({ row: { decision } }: PlacedRow) => decision?.candidate ?? '';

const ROWS: readonly Column<PlacedRow>[] = [
  { id: 'time', title: 'Time', sort: timeOf,
    cell: (placed) => <a href={hrefWith('row', rowId(placed.row))}>{timeOf(placed) ? timeText(timeOf(placed)!) : `row ${placed.row.row}`}</a> },
  { id: 'kind', title: 'Kind', isText: true, sort: ({ row }) => kindWord(row.kind).name,
    cell: ({ row }) => <span title={kindWord(row.kind).meaning}><span aria-hidden="true">{kindWord(row.kind).mark} </span>{kindWord(row.kind).name}</span> },
  { id: 'decision', title: 'Decision', sort: ({ row }) => row.decision && Number(row.decision.id), cell: ({ row }) => String(row.decision?.id ?? '–') },
  { id: 'active', title: 'Active algorithm', isText: true, sort: armOf,
    cell: (placed) => (armOf(placed) ? <Arm name={armOf(placed)} /> : '–') },
  { id: 'candidate', title: 'Candidate', isText: true, sort: candidateOf,
    cell: (placed) => (candidateOf(placed) ? <Arm name={candidateOf(placed)} hollow /> : '–') },
  { id: 'outcome', title: 'Outcome', isText: true, sort: outcomeText, cell: (placed) => outcomeText(placed) || '–' },
  { id: 'words', title: 'In words', isText: true, cell: (placed) => <bdi class="words">{wordsOf(placed)}</bdi> },
  { id: 'session', title: 'Session', isText: true, sort: ({ row }) => row.session, cell: ({ row }) => <a href={sessionHref(row.session)}><Name text={row.session} /></a> },
];

const PARAMETERS = ['session', 'project', 'scene', 'kind', 'outcome', 'arm', 'from', 'until', 'older', 'newer', 'row'] as const;
type Asked = Readonly<Record<typeof PARAMETERS[number], string>>;
const asked = () => Object.fromEntries(PARAMETERS.map((name) => [name, route.value.query.get(name) ?? ''])) as Asked;

/** Returns the value of an enumeration that has this name, as a list; empty if there is none. */
const named = (names: Readonly<Record<string, string | number>>, name: string) => (typeof names[name] === 'number' ? [names[name]] : []);

const selectionOf = ({ session, project, scene, kind, outcome, arm, from, until }: Asked): Selection => ({
  sessionId: session, project, scene, kinds: named(AuditKind, kind), outcomes: named(DecisionOutcome, outcome), arm,
  unixFromMs: BigInt(Math.floor(Number(from)) || 0), unixUntilMs: BigInt(Math.floor(Number(until)) || 0),
});

function OneRow({ id }: { id: string }) {
  const close = () => setQuery({ row: undefined });
  useEffect(() => addShortcuts([{ keys: 'Escape', what: 'Close the explanation', run: close }]), []);
  const reading = useReading(id, (cancel) => readRow(id, cancel));
  const missing = <Empty title="The log does not have this row"><p>The row was removed because the size of the log is limited, or it never existed.</p></Empty>;
  const shown = (placed: PlacedRow) => {
    const step = stepOfRow(placed);
    return step
      ? <Why step={step} sessionId={placed.row.session} onRead={reading.again} onClose={close} />
      : <p class="why">{explainedRow(placed.row, placed.setup).map((sentence) => <bdi key={sentence}>{visible(sentence)}</bdi>)} <button type="button" class="quiet" onClick={close}>Close</button></p>;
  };
  return <Read reading={reading} what="the row">{(placed) => (placed ? shown(placed) : missing)}</Read>;
}

/** Buttons for the pages. A page has a place of its own in the URL, so that later rows do not move it. */
function Pager({ older, newer, part: { olderToken, newerToken, hasMore } }: Pick<Asked, 'older' | 'newer'> & { part: LogPart }) {
  const go = (place: { older?: string; newer?: string }) => setQuery({ older: undefined, newer: undefined, ...place }, { step: true });
  const isFirst = !older && !newer;
  return (
    <nav class="orders" aria-label="Pages">
      <button type="button" disabled={isFirst} onClick={() => go({})}>Newest</button>
      <button type="button" disabled={isFirst || (newer !== '' && !hasMore)} onClick={() => go({ newer: newerToken })}>Newer</button>
      <button type="button" disabled={newer === '' && !hasMore} onClick={() => go({ older: olderToken })}>Older</button>
      {isFirst && <PauseButton />}
    </nav>
  );
}

const choicesOf = <Value extends number>(names: Readonly<Record<string, string | number>>, wordOf: (value: Value) => { name: string }) =>
  [['', 'any'], ...Object.entries(names).filter(([, value]) => Number(value) > 0)
    .map(([name, value]) => [name, wordOf(value as Value).name] as const)] as const;
const KINDS = choicesOf<AuditKind>(AuditKind, kindWord).filter(([name]) => name !== 'MISSING'); // the daemon lists no such rows
const OUTCOMES = choicesOf<DecisionOutcome>(DecisionOutcome, outcomeWord);

const anyOf = (names: readonly string[]) => [['', 'any'], ...[...new Set(names)].filter(Boolean).sort().map((name) => [name, visible(name)] as const)] as const;

function Filters({ all, rows }: { all: Asked; rows: readonly PlacedRow[] }) {
  const known = [...scenes.value.values()].map(({ posterior }) => posterior);
  const inProject = known.filter(({ project }) => !all.project || project === all.project);
  return (
    <>
      {!all.session && <Choice label="Project" parameter="project" options={anyOf([...known.map(({ project }) => project), all.project])} />}
      {!all.session && <Choice label="Scene" parameter="scene" options={anyOf([...inProject.map(({ scene }) => scene), all.scene])} />}
      <Choice label="Kind" parameter="kind" options={KINDS} />
      <Choice label="Outcome" parameter="outcome" options={OUTCOMES} />
      <Choice label="Algorithm" parameter="arm" options={anyOf([...rows.flatMap(({ setup }) => setup?.arms ?? []), all.arm])} />
      <TimeChoice label="From" parameter="from" />
      <TimeChoice label="Until" parameter="until" />
    </>
  );
}

function Rows({ all }: { all: Asked }) {
  const { session, older, newer } = all;
  const selection = selectionOf(all);
  const isFirst = !older && !newer;
  const latest = session ? sessions.value.get(session)?.decisions.at(-1) : sessions.value; // changes with each decision
  const { rows: part, error, isBusy, atMs, again } = useLog<LogPart>(isFirst && pausedMs.value === undefined ? latest : undefined, async (before, cancel) => {
    if (!before || !isFirst || before.rows.length > MAX_ROWS) return readRows(selection, PAGE_ROWS, cancel, { olderThan: older, newerThan: newer });
    const added = await readRows(selection, MAX_ROWS, cancel, { newerThan: before.newerToken });
    return { ...before, rows: [...added.rows, ...before.rows], newerToken: added.newerToken };
  }, READ_AFTER_MS);
  const csvHref = csvUrl('decisions', { filter: toJson(DecisionFilterSchema, create(DecisionFilterSchema, selection)) });
  return (
    <>
      <div class="tools">
        <Filters all={all} rows={part?.rows ?? []} />
        <button type="button" onClick={again} disabled={isBusy}>Read again</button>
        {part && <span class="soft">read {ago(atMs, now.value)}{error && <span role="status">: {error.message}; the page tries again</span>}</span>}
      </div>
      {error && !part && <Failure what="the log" error={error} onRetry={again} />}
      {!error && !part && <Loading what="the log" />}
      {part && <Pager {...all} part={part} />}
      {part && part.rows.length > 0 && <Table caption="Rows" csvHref={csvHref} columns={ROWS} rows={part.rows} keyOf={({ row }) => rowId(row)} sort="" sortParameter="rows" />}
      {part?.rows.length === 0 && <Empty title="No row of the log matches the filter" />}
    </>
  );
}

function Heading({ session, project, scene }: Asked) {
  if (session === ADMIN) return <>Administration</>;
  if (session) return <>Decisions of session <a href={sessionHref(session)}><Name text={session} /></a></>;
  if (scene) return <>Decisions in <Name text={scene} /></>;
  return project ? <>Decisions of <Name text={project} /></> : <>Decisions</>;
}

export function DecisionsView() {
  const all = asked();
  const isList = route.value.query.has('logs');
  const { row, ...place } = all;
  return (
    <>
      <header class="title"><h1>{isList ? 'Logs' : <Heading {...all} />}</h1><CopyLink /></header>
      <p>The log of a session has a row for every decision and for every event that decisions depend on.{' '}
        {(isList || all.session || all.scene || all.project) && <><a href={decisionsHref({})}>All decisions</a> </>}
        {!isList && <a href={decisionsHref({ logs: 'all' })}>Sessions with a log</a>}</p>
      {row && <OneRow key={row} id={row} />}
      {isList ? <Segments /> : <Rows key={JSON.stringify(place)} all={all} />}
    </>
  );
}
