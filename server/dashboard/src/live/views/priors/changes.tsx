// Two builds beside one another: where they say something else of what arms cost.
import { useMemo } from 'preact/hooks';
import { ChartFrame } from '../../charts/frame';
import { Intervals } from '../../charts/intervals';
import { LOG_COST_REWARD_VERSION, type Ratio } from '../../numbers/log_cost';
import { type ArmChange, buildChanges, byWeight, isChange, type SceneChange } from '../../numbers/priors_diff';
import { Arm } from '../../parts/arm';
import { Chip } from '../../parts/chips';
import { Choice } from '../../parts/filter';
import { Name } from '../../parts/name';
import { type Column, Table } from '../../parts/table';
import { visible } from '../../parts/visible';
import type { Evidence } from '../../state/evidence';
import { route, sceneHref } from '../../state/route';

interface Row extends ArmChange { scene: SceneChange; key: string }

// More pictures than these nobody looks at; the table has all scenes.
const MAX_PICTURES = 6;

const ratioText = (ratio: Ratio | undefined) => ratio?.median.toFixed(2) ?? '–';

function changeWord(change: ArmChange): string {
  if (!isChange(change)) return 'the same';
  if (change.before === undefined) return 'new';
  if (change.after === undefined) return 'not measured';
  return change.after.median > change.before.median ? 'dearer' : 'cheaper';
}

const LEADER_WORDS: Readonly<Record<SceneChange['leader'], string>> = { same: 'the same', other: 'another', 'in one': 'in one build only' };

const COLUMNS: readonly Column<Row>[] = [
  { id: 'scene', title: 'Scene', sort: ({ scene }) => `${scene.project}\n${scene.scene}\n${scene.machineClass}`, csv: ({ scene }) => scene.scene,
    cell: ({ scene }) => <a href={sceneHref({ ...scene, rewardVersion: LOG_COST_REWARD_VERSION })}><Name text={scene.scene} /></a> },
  { id: 'arm', title: 'Arm', isText: true, sort: ({ arm }) => arm, cell: ({ arm }) => <Arm name={arm} /> },
  { id: 'before', title: 'Cost before', hint: 'Of the arm ÷ that of the scene’s cheapest one, in the first build', sort: ({ before }) => before?.median, cell: ({ before }) => ratioText(before) },
  { id: 'after', title: 'Cost after', hint: 'The same in the second build', sort: ({ after }) => after?.median, cell: ({ after }) => ratioText(after) },
  { id: 'change', title: 'Change', isText: true, hint: 'Of more than 5 %, relative to the cheapest arm', sort: changeWord,
    cell: (row) => <Chip tone={isChange(row) ? 'warn' : 'plain'}>{changeWord(row)}</Chip> },
  { id: 'leader', title: 'Cheapest arm', isText: true, hint: 'Whether an arm is the cheapest one in both', sort: ({ scene }) => LEADER_WORDS[scene.leader],
    cell: ({ scene: { leader } }) => (leader === 'other' ? <Chip tone="bad" sign="≠">another</Chip> : LEADER_WORDS[leader]) },
  { id: 'class', title: 'Machines', isText: true, sort: ({ scene }) => scene.machineClass, cell: ({ scene }) => <Name text={scene.machineClass} /> },
  { id: 'project', title: 'Project', isText: true, sort: ({ scene }) => scene.project, cell: ({ scene }) => <Name text={scene.project} /> },
];

function Picture({ change: { project, scene, machineClass, arms }, before, after }: { change: SceneChange; before: string; after: string }) {
  const title = `What arms cost in ${visible(scene)}${machineClass && ` on ${visible(machineClass)}`}`;
  const table = () => ({
    header: ['arm', `cost ratio in ${before}`, '95 % from', 'to', `in ${after}`, '95 % from', 'to'],
    rows: arms.map(({ arm, ...change }) => [arm, ...[change.before, change.after].flatMap((ratio) => [ratio?.median, ratio?.low, ratio?.high])]),
  });
  return (
    <ChartFrame id="changes" title={title} names={[project, scene, machineClass, before, after]} table={table}
      note={<>Hollow: build <Name text={before} />; filled: build <Name text={after} />. Lines: where it is with 95 %.</>}>
      <Intervals title={title} rows={arms} unit="cost ÷ that of the cheapest arm (less is better)" />
    </ChartFrame>
  );
}

function Pictures({ changes, before, after }: { changes: readonly SceneChange[]; before: string; after: string }) {
  const shown = useMemo(() => [...changes].sort(byWeight).slice(0, MAX_PICTURES), [changes]);
  return (
    <>
      <div class="beside">{shown.map((change) => <Picture key={[change.project, change.scene, change.machineClass].join('\n')} change={change} before={before} after={after} />)}</div>
      {changes.length > shown.length && <p class="soft small">Drawn are {MAX_PICTURES} of {changes.length} scenes: those where another arm is the cheapest one, then those that differ most, last those of one build.</p>}
    </>
  );
}

function Differences({ evidence, before, after }: { evidence: Evidence; before: string; after: string }) {
  const changes = useMemo(() => buildChanges(evidence.sums.values(), before, after), [evidence, before, after]);
  const rows = useMemo(() => changes.flatMap((scene): Row[] =>
    scene.arms.map((change) => ({ ...change, scene, key: [scene.project, scene.scene, scene.machineClass, change.arm].join('\n') }))), [changes]);
  if (rows.length === 0) return <p role="status">The builds agree on every scene to within 5 %.</p>;
  return (
    <>
      <Pictures changes={changes} before={before} after={after} />
      <Table caption="Changes" columns={COLUMNS} rows={rows} keyOf={({ key }) => key} sort="scene" sortParameter="changes" />
      <p class="soft small">Scenes in which something changes, from the evidence of each build alone; <code>sweepstake priors diff</code> says the same of an export. Only
        rewards that tell costs compare (version {LOG_COST_REWARD_VERSION}).</p>
    </>
  );
}

export function Changes({ evidence }: { evidence: Evidence }) {
  const chosen = [route.value.query.get('before') ?? '', route.value.query.get('after') ?? ''] as const;
  const known = [...evidence.builds.values()].map(({ build }) => build);
  const builds = [...new Set([...known, ...chosen])].filter(Boolean).sort();
  const options = [['', 'choose'], ...builds.map((build) => [build, visible(build)] as const)] as const;
  const missing = chosen.find((build) => build && !known.includes(build));
  return (
    <>
      <div class="tools">
        <Choice label="From build" parameter="before" options={options} />
        <Choice label="to build" parameter="after" options={options} />
      </div>
      {builds.length < 2 && <p class="soft">A game says its build when it begins a session (<code>--build</code>, <code>SessionOptions::build</code>); two are needed.</p>}
      {missing && <p class="soft">There is no evidence of build <Name text={missing} /> here.</p>}
      {chosen[0] && chosen[1] && !missing && <Differences evidence={evidence} before={chosen[0]} after={chosen[1]} />}
    </>
  );
}
