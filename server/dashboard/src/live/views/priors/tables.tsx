// Tables of the evidence: in quarantine, by build, by scene and arm, and by source.
import { grouped, significant } from '../../../format';
import { Arm } from '../../parts/arm';
import { timeText } from '../../parts/clock';
import { matches } from '../../parts/filter';
import { Name } from '../../parts/name';
import { type Column, Table } from '../../parts/table';
import type { BuildSum, Evidence, EvidenceSum, SourceSum } from '../../state/evidence';
import { decisionsHref, route, sceneHref, sessionHref } from '../../state/route';
import { sessions } from '../../state/sessions';
import { PromoteButton, RevokeButton } from './question';

const LANE = 'lane'; // measured_by of the shadow lane; the frame thread has no name

type Teacher = BuildSum | SourceSum;
const list = (names: ReadonlySet<string>) => [...names].join(', ');

// The columns that builds and sources have in common.
const TAUGHT: readonly Column<Teacher>[] = [
  { id: 'windows', title: 'Windows', hint: 'Decision windows, and visits of the lane', sort: (row) => row.windowCount, cell: (row) => grouped(row.windowCount) },
  { id: 'bails', title: 'Bail-outs', sort: (row) => row.bailOutCount, cell: (row) => grouped(row.bailOutCount) },
  { id: 'arms', title: 'Arms', sort: (row) => row.arms.size, cell: (row) => grouped(row.arms.size) },
  { id: 'seen', title: 'Last seen', hint: 'When it last added evidence, by the clock of its daemon', sort: (row) => row.lastSeenS || undefined,
    csv: (row) => (row.lastSeenS ? new Date(1000 * row.lastSeenS).toISOString() : ''), cell: (row) => (row.lastSeenS ? timeText(1000 * row.lastSeenS) : '–') },
  { id: 'classes', title: 'Machines', isText: true, sort: (row) => list(row.machineClasses), cell: (row) => <Name text={list(row.machineClasses)} /> },
  { id: 'scenes', title: 'Scenes', isText: true, sort: (row) => list(row.scenes), cell: (row) => <Name text={list(row.scenes)} /> },
  { id: 'project', title: 'Project', isText: true, sort: (row) => row.project, cell: (row) => <Name text={row.project} /> },
];

const BUILDS: readonly Column<BuildSum>[] = [
  { id: 'build', title: 'Build', sort: ({ build }) => build, cell: ({ build }) => <Name text={build} /> },
  { id: 'revoke', title: 'Revoke', isText: true, cell: ({ project, build }) => build && <RevokeButton scope={{ project, build }} of={`build ${build}`} /> },
  { id: 'sources', title: 'Sources', hint: 'Sessions and imported sources', sort: ({ sourceIds }) => sourceIds.size, cell: ({ sourceIds }) => grouped(sourceIds.size) },
  ...TAUGHT,
];

const WAITING: readonly Column<BuildSum>[] = [
  { id: 'build', title: 'Build', sort: ({ build }) => build, cell: ({ build }) => <Name text={build} /> },
  { id: 'promote', title: 'Promote', isText: true, cell: ({ project, build }) => build && <PromoteButton scope={{ project, build }} of={`build ${build}`} /> },
  { id: 'sources', title: 'Sources', hint: 'Imported sources', sort: ({ sourceIds }) => sourceIds.size, cell: ({ sourceIds }) => grouped(sourceIds.size) },
  ...TAUGHT,
];

// A session that is no longer in memory is shown by its rows in the audit log.
const sourceHref = (id: string) => (sessions.value.has(id) ? sessionHref(id) : decisionsHref({ session: id }));
const originOf = ({ isImported }: SourceSum) => (isImported ? 'import' : 'session');

const SOURCES: readonly Column<SourceSum>[] = [
  { id: 'source', title: 'Source', sort: ({ sourceId }) => sourceId,
    cell: ({ sourceId, isImported }) => (isImported ? <Name text={sourceId} /> : <a href={sourceHref(sourceId)}><Name text={sourceId} /></a>) },
  { id: 'revoke', title: 'Revoke', isText: true, cell: ({ project, sourceId }) => <RevokeButton scope={{ project, sourceId }} of={`source ${sourceId}`} /> },
  { id: 'origin', title: 'Origin', isText: true, hint: 'A session of this daemon, or the import of a file of priors', sort: originOf, cell: originOf },
  { id: 'build', title: 'Build', isText: true, sort: ({ build }) => build, cell: ({ build }) => <Name text={build} /> },
  { id: 'weight', title: 'Weight', hint: 'How much it counts, at most, in a new session on its class of machines, of the build that was seen last in its scenes, with the newest backends. '
    + '0: newer sources of every arm have taken its place. 1: where rewards do not tell costs, all sources are summed', sort: ({ weight }) => weight, cell: ({ weight }) => significant(weight) },
  ...TAUGHT,
];

const SUMS: readonly Column<EvidenceSum>[] = [
  { id: 'scene', title: 'Scene', sort: ({ example }) => `${example.project}\n${example.scene}`, csv: ({ example }) => example.scene,
    cell: ({ example }) => <a href={sceneHref(example)}><Name text={example.scene} /></a> },
  { id: 'arm', title: 'Arm', isText: true, sort: ({ example }) => example.arm, cell: ({ example }) => <Arm name={example.arm} hollow={example.measuredBy === LANE} /> },
  { id: 'by', title: 'Measured', isText: true, hint: 'On the frame thread of games, or beside it in the shadow lane', sort: ({ example }) => example.measuredBy,
    csv: ({ example }) => example.measuredBy || 'live', cell: ({ example }) => (example.measuredBy === LANE ? 'shadow lane' : 'live') },
  { id: 'build', title: 'Build', isText: true, sort: ({ example }) => example.build, cell: ({ example }) => <Name text={example.build} /> },
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

const textsOf = ({ project, build, scenes, machineClasses }: Teacher) => [project, build, ...scenes, ...machineClasses];

export function Builds({ evidence }: { evidence: Evidence }) {
  const filter = route.value.query.get('q') ?? '';
  const rows = [...evidence.builds.values()].filter((build) => matches(filter, textsOf(build)));
  return <Table caption="Builds" columns={BUILDS} rows={rows} keyOf={({ key }) => key} sort="-seen" sortParameter="builds" />;
}

export function Waiting({ evidence }: { evidence: Evidence }) {
  return <Table caption="Quarantine" columns={WAITING} rows={[...evidence.waiting.values()]} keyOf={({ key }) => key} sort="build" sortParameter="waiting" />;
}

export function Sums({ evidence }: { evidence: Evidence }) {
  const filter = route.value.query.get('q') ?? '';
  const rows = [...evidence.sums.values()].filter(({ example }) => matches(filter, [example.project, example.scene, example.build, example.arm, example.machineClass]));
  return <Table caption="Sums of evidence" columns={SUMS} rows={rows} keyOf={({ key }) => key} sort="scene" />;
}

export function Sources({ evidence }: { evidence: Evidence }) {
  const filter = route.value.query.get('q') ?? '';
  const rows = [...evidence.sources.values()].filter((source) => matches(filter, [source.sourceId, ...textsOf(source)]));
  return <Table caption="Sources" columns={SOURCES} rows={rows} keyOf={({ sourceId }) => sourceId} sort="-windows" sortParameter="sources" />;
}
