// Shows the scenes in which the cost ratios of arms differ between two builds. The daemon compares them.
import { useMemo } from 'preact/hooks';
import { type ArmComparison, PriorsService, type SceneComparison } from '../../../gen/sweepstake/v1/priors_pb';
import { counted } from '../../../format';
import { ChartFrame } from '../../charts/frame';
import { Intervals } from '../../charts/intervals';
import { LOG_COST_REWARD_VERSION } from '../../numbers/log_cost';
import { Arm } from '../../parts/arm';
import { Chip } from '../../parts/chips';
import { Choice } from '../../parts/filter';
import { Name, visible } from '../../parts/name';
import { Read } from '../../parts/states';
import { type Column, Table } from '../../parts/table';
import { route, sceneHref } from '../../state/route';
import { useList } from '../../transport/reading';

interface Row { scene: SceneComparison; change: ArmComparison; key: string }

// The table has all scenes, the pictures only the first ones.
const MAX_PICTURES = 6;

const beforeOf = ({ before }: ArmComparison) => before?.costRatio;
const afterOf = ({ after }: ArmComparison) => after?.costRatio;
const ratioText = (ratio: { median: number } | undefined) => ratio?.median.toFixed(2) ?? '–';
const keyOf = ({ project, scene, machineClass, regime }: SceneComparison) => [project, scene, machineClass, regime].join('\n');

function changeWord(change: ArmComparison): string {
  const [before, after] = [beforeOf(change), afterOf(change)];
  if (!change.changed) return 'the same';
  if (!before) return 'new';
  if (!after) return 'not measured';
  return after.median > before.median ? 'dearer' : 'cheaper';
}

const leaderWord = ({ knownInBoth, leaderChanged }: SceneComparison) => (!knownInBoth ? 'in one build only' : leaderChanged ? 'another' : 'the same');

/** Orders scenes: first those with another cheapest arm, then those known in both builds, then by the largest change. */
export const byWeight = (a: SceneComparison, b: SceneComparison) =>
  Number(b.leaderChanged) - Number(a.leaderChanged) || Number(b.knownInBoth) - Number(a.knownInBoth) || b.largestLogChange - a.largestLogChange || a.scene.localeCompare(b.scene);

const COLUMNS: readonly Column<Row>[] = [
  { id: 'scene', title: 'Scene', sort: ({ scene }) => `${scene.project}\n${scene.scene}\n${scene.machineClass}`,
    cell: ({ scene }) => <a href={sceneHref(scene)}><Name text={scene.scene} /></a> },
  { id: 'arm', title: 'Algorithm', isText: true, sort: ({ change }) => change.arm, cell: ({ change }) => <Arm name={change.arm} /> },
  { id: 'before', title: 'Cost before', hint: 'Cost of the algorithm ÷ that of the scene’s cheapest algorithm, in the first build', sort: ({ change }) => beforeOf(change)?.median, cell: ({ change }) => ratioText(beforeOf(change)) },
  { id: 'after', title: 'Cost after', hint: 'Cost of the algorithm ÷ that of the scene’s cheapest algorithm, in the second build', sort: ({ change }) => afterOf(change)?.median, cell: ({ change }) => ratioText(afterOf(change)) },
  { id: 'change', title: 'Change', isText: true, hint: 'Whether the cost ratio differs by more than 5 % between the builds, or is known in one of them only', sort: ({ change }) => changeWord(change),
    cell: ({ change }) => <Chip tone={change.changed ? 'warn' : 'plain'}>{changeWord(change)}</Chip> },
  { id: 'leader', title: 'Cheapest algorithm', isText: true, hint: 'Whether the same algorithm is the cheapest in both builds', sort: ({ scene }) => leaderWord(scene),
    cell: ({ scene }) => (scene.leaderChanged ? <Chip tone="bad" sign="≠">another</Chip> : leaderWord(scene)) },
  { id: 'regime', title: 'Regime', isText: true, hint: 'Object count, mean speed and share of static objects, each in steps of the regimes', sort: ({ scene }) => scene.regime,
    cell: ({ scene }) => <Name text={scene.regime} unknown="–" /> },
  { id: 'class', title: 'Machines', isText: true, sort: ({ scene }) => scene.machineClass },
  { id: 'project', title: 'Project', isText: true, sort: ({ scene }) => scene.project },
];

function Picture({ change: { project, scene, machineClass, regime, arms }, before, after }: Builds & { change: SceneComparison }) {
  const title = `What algorithms cost in ${visible(scene)}${machineClass && ` on ${visible(machineClass)}`}${regime && `, regime ${visible(regime)}`}`;
  const rows = arms.map((change) => ({ arm: change.arm, before: beforeOf(change), after: afterOf(change) }));
  const table = () => ({
    header: ['algorithm', `cost ratio in ${before}`, '95 % from', 'to', `in ${after}`, '95 % from', 'to'],
    rows: rows.map(({ arm, ...change }) => [arm, ...[change.before, change.after].flatMap((ratio) => [ratio?.median, ratio?.low, ratio?.high])]),
  });
  return (
    <ChartFrame id="changes" title={title} names={[project, scene, machineClass, regime, before, after]} table={table}
      note={<>Hollow: build <Name text={before} />. Filled: build <Name text={after} />. Lines: 95 % intervals.</>}>
      <Intervals title={title} rows={rows} unit="cost ÷ that of the cheapest algorithm (less is better)" />
    </ChartFrame>
  );
}

function Pictures({ changes, before, after }: Builds & { changes: readonly SceneComparison[] }) {
  const shown = useMemo(() => [...changes].sort(byWeight).slice(0, MAX_PICTURES), [changes]);
  return (
    <>
      <div class="beside">{shown.map((change) => <Picture key={keyOf(change)} change={change} before={before} after={after} />)}</div>
      {changes.length > shown.length && <p class="soft small">The page draws {MAX_PICTURES} of {changes.length} scenes and regimes. Those with another cheapest algorithm come first, then those with the largest change, and last those of one build only.</p>}
    </>
  );
}

interface Builds { before: string; after: string }

function ChangeTable({ changes, before, after }: Builds & { changes: readonly SceneComparison[] }) {
  const rows = changes.flatMap((scene): Row[] => scene.arms.map((change) => ({ scene, change, key: `${keyOf(scene)}\n${change.arm}` })));
  if (rows.length === 0) return <p role="status">The builds agree on every scene to within 5 %.</p>;
  return (
    <>
      <p role="status">From build <Name text={before} /> to build <Name text={after} />, cost ratios differ in {counted(changes.length, 'scene or regime', 'scenes and regimes')}. Another algorithm is the cheapest in{' '}
        <b>{changes.filter(({ leaderChanged }) => leaderChanged).length}</b> of them.</p>
      <Pictures changes={changes} before={before} after={after} />
      <Table caption="Changes" columns={COLUMNS} rows={rows} keyOf={({ key }) => key} sort="scene" sortParameter="changes" />
      <p class="soft small">The table lists the scenes in which the cost ratio of an algorithm has changed. It uses the evidence of each build alone. <code>sweepstake priors diff</code> compares exported files in the same way. Only
        rewards of version {LOG_COST_REWARD_VERSION} can be compared, since they depend on the cost alone.</p>
    </>
  );
}

function Differences({ project, before, after }: Builds & { project: string }) {
  const reading = useList(PriorsService.method.compareBuilds, { project, before: { build: before }, after: { build: after }, changesOnly: true });
  const table = (changes: readonly SceneComparison[]) => <ChangeTable changes={changes} before={before} after={after} />;
  return <Read reading={reading} what="the comparison">{(parts) => table(parts.flatMap(({ scenes }) => scenes))}</Read>;
}

/** `known` are the builds with evidence, the latest first. Without a choice in the URL, the two latest ones are compared. */
export function Changes({ known, project }: { known: readonly string[]; project: string }) {
  const named = known.filter(Boolean);
  const chosen = [route.value.query.get('before') ?? named[1] ?? '', route.value.query.get('after') ?? named[0] ?? ''] as const;
  const builds = [...new Set([...known, ...chosen])].filter(Boolean).sort();
  const optionsFor = (first: string) => [...new Set([first, ...builds])].map((build) => [build, visible(build) || 'choose'] as const);
  const missing = chosen.find((build) => build && !known.includes(build));
  return (
    <>
      <div class="tools">
        <Choice label="From build" parameter="before" options={optionsFor(named[1] ?? '')} />
        <Choice label="to build" parameter="after" options={optionsFor(named[0] ?? '')} />
      </div>
      {builds.length < 2 && <p class="soft">A comparison needs two builds. A game sends its build when it begins a session (<code>--build</code>, <code>SessionOptions::build</code>).</p>}
      {missing && <p class="soft">There is no evidence of build <Name text={missing} /> here.</p>}
      {chosen[0] && chosen[1] && !missing && <Differences project={project} before={chosen[0]} after={chosen[1]} />}
    </>
  );
}
