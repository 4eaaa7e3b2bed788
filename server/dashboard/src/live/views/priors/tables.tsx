// Tables of the evidence: in quarantine, by build, by scene and arm, and by source.
import { useMemo } from 'preact/hooks';
import { significant } from '../../../format';
import { Arm } from '../../parts/arm';
import { timeText } from '../../parts/clock';
import { matches } from '../../parts/filter';
import { Name } from '../../parts/name';
import { type Column, Table } from '../../parts/table';
import { type Group, groupsOf } from '../../state/evidence';
import { decisionsHref, route, sceneHref, sessionHref } from '../../state/route';
import { sessions } from '../../state/sessions';
import type { PriorRecord } from '../../../gen/sweepstake/v1/priors_pb';
import { PromoteButton, RevokeButton } from './question';

const LANE = 'lane'; // measured_by of the shadow lane; the frame thread has no name

const list = (names: ReadonlySet<string>) => [...names].join(', ');
const NUMBERS: readonly Column<Group>[] = [
  { id: 'windows', title: 'Windows', hint: 'Decision windows, and visits of the lane', sort: (row) => row.windowCount },
  { id: 'bails', title: 'Bail-outs', sort: (row) => row.bailOutCount },
];
const BUILD: Column<Group> = { id: 'build', title: 'Build', isText: true, sort: ({ example }) => example.build };
const SOURCE_COUNT: Column<Group> = { id: 'sources', title: 'Sources', hint: 'Sessions and imported sources', sort: ({ sourceIds }) => sourceIds.size };
const PROJECT: Column<Group> = { id: 'project', title: 'Project', isText: true, sort: ({ example }) => example.project };

// The columns that builds and sources have in common.
const ORIGIN: readonly Column<Group>[] = [
  ...NUMBERS,
  { id: 'arms', title: 'Arms', sort: (row) => row.arms.size },
  { id: 'seen', title: 'Last seen', hint: 'When it last added evidence, by the clock of its daemon', sort: (row) => row.lastSeenS || undefined,
    csv: (row) => (row.lastSeenS ? new Date(1000 * row.lastSeenS).toISOString() : ''), cell: (row) => (row.lastSeenS ? timeText(1000 * row.lastSeenS) : '–') },
  { id: 'classes', title: 'Machines', isText: true, sort: (row) => list(row.machineClasses) },
  { id: 'scenes', title: 'Scenes', isText: true, sort: (row) => list(row.scenes) },
  PROJECT,
];

const BUILDS: readonly Column<Group>[] = [
  BUILD,
  { id: 'revoke', title: 'Revoke', isText: true,
    cell: ({ example: { project, build } }) => build && <RevokeButton scope={{ project, build }} of={`build ${build}`} /> },
  SOURCE_COUNT, ...ORIGIN,
];

const WAITING: readonly Column<Group>[] = [
  BUILD,
  { id: 'promote', title: 'Promote', isText: true,
    cell: ({ example: { project, build } }) => build && <PromoteButton scope={{ project, build }} of={`build ${build}`} /> },
  SOURCE_COUNT, ...ORIGIN,
];

// A session that is no longer in memory is shown by its rows in the audit log.
const sourceHref = (id: string) => (sessions.value.has(id) ? sessionHref(id) : decisionsHref({ session: id }));

const SOURCES: readonly Column<Group>[] = [
  { id: 'source', title: 'Source', sort: ({ key }) => key,
    cell: ({ key, example: { isImported } }) => (isImported ? <Name text={key} /> : <a href={sourceHref(key)}><Name text={key} /></a>) },
  { id: 'revoke', title: 'Revoke', isText: true,
    cell: ({ example: { project, sourceId } }) => <RevokeButton scope={{ project, sourceId }} of={`source ${sourceId}`} /> },
  { id: 'origin', title: 'Origin', isText: true, hint: 'A session of this daemon, or the import of a file of priors',
    sort: ({ example }) => (example.isImported ? 'import' : 'session') },
  BUILD,
  { id: 'weight', title: 'Weight', hint: 'The highest weight of its records in a new session on its class of machines, with the build that was seen last in the scene and '
    + 'the newest backends. 0: newer sources of every arm have replaced it. 1: rewards do not depend on the cost alone, and all sources are summed',
    sort: ({ weight }) => weight, cell: ({ weight }) => significant(weight) },
  ...ORIGIN,
];

const meanOf = ({ alpha, beta }: Group) => (alpha + beta > 0 ? alpha / (alpha + beta) : undefined);

const SUMS: readonly Column<Group>[] = [
  { id: 'scene', title: 'Scene', sort: ({ example }) => `${example.project}\n${example.scene}`, csv: ({ example }) => example.scene,
    cell: ({ example }) => <a href={sceneHref(example)}><Name text={example.scene} /></a> },
  { id: 'arm', title: 'Arm', isText: true, sort: ({ example }) => example.arm,
    cell: ({ example }) => <Arm name={example.arm} hollow={example.measuredBy === LANE} /> },
  { id: 'by', title: 'Measured', isText: true, hint: 'On the frame thread of games, or beside it in the shadow lane',
    sort: ({ example }) => (example.measuredBy === LANE ? 'shadow lane' : 'live') },
  BUILD,
  { id: 'backend', title: 'Version', hint: 'Version of the backend’s code; evidence of different versions is kept apart', sort: ({ example }) => example.backendVersion },
  SOURCE_COUNT, ...NUMBERS,
  { id: 'mean', title: 'Mean reward', hint: 'α ÷ (α + β) of the evidence alone', sort: meanOf, cell: (row) => meanOf(row)?.toFixed(4) ?? '–' },
  { id: 'alpha', title: 'α', hint: 'Successes, without any prior', sort: (row) => row.alpha, cell: (row) => significant(row.alpha, 4) },
  { id: 'beta', title: 'β', hint: 'Failures, without any prior', sort: (row) => row.beta, cell: (row) => significant(row.beta, 4) },
  PROJECT,
  { id: 'class', title: 'Machines', isText: true, sort: ({ example }) => example.machineClass },
  { id: 'reward', title: 'Reward', sort: ({ example }) => example.rewardVersion },
];

interface GroupsProps { records: readonly PriorRecord[]; by: readonly (keyof PriorRecord)[]; columns: readonly Column<Group>[]; caption: string; sort: string; sortParameter?: string }

function Groups({ records, by, ...table }: GroupsProps) {
  const groups = useMemo(() => groupsOf(records, ...by), [records]);
  const filter = route.value.query.get('q') ?? '';
  const rows = groups.filter(({ key, scenes, arms, machineClasses }) => matches(filter, [key, ...scenes, ...arms, ...machineClasses]));
  return <Table {...table} rows={rows} keyOf={({ key }) => key} />;
}

interface Records { records: readonly PriorRecord[] }

const BY_BUILD = ['project', 'build'] as const;
const BY_ARM = [...BY_BUILD, 'scene', 'machineClass', 'rewardVersion', 'arm', 'backendVersion', 'measuredBy'] as const;

export const Waiting = (records: Records) => <Groups {...records} by={BY_BUILD} columns={WAITING} caption="Quarantine" sort="build" sortParameter="waiting" />;
export const Builds = (records: Records) => <Groups {...records} by={BY_BUILD} columns={BUILDS} caption="Builds" sort="-seen" sortParameter="builds" />;
export const Sums = (records: Records) => <Groups {...records} by={BY_ARM} columns={SUMS} caption="Sums of evidence" sort="scene" />;
export const Sources = (records: Records) => <Groups {...records} by={['sourceId']} columns={SOURCES} caption="Sources" sort="-windows" sortParameter="sources" />;
