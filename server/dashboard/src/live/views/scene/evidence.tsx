// The evidence behind a scene's posteriors, separated by the measuring thread and by build. The page reads it on request.
import { useState } from 'preact/hooks';
import { type CompareBuildsResponse, PriorsService, type SceneComparison } from '../../../gen/sweepstake/v1/priors_pb';
import { RidgeFigure, type RidgeRow } from '../../charts/ridgeline';
import { csvUrl } from '../../parts/download';
import { Choice } from '../../parts/filter';
import { Name, visible } from '../../parts/name';
import { Read } from '../../parts/states';
import { route } from '../../state/route';
import type { SceneName } from '../../state/scenes';
import { useList } from '../../transport/reading';

const NO_EVIDENCE = 'No evidence of this scene is stored yet.';

const find = (parts: readonly CompareBuildsResponse[], { machineClass, rewardVersion }: SceneName) =>
  parts.flatMap(({ scenes }) => scenes).find((scene) => scene.machineClass === machineClass && scene.rewardVersion === rewardVersion);

function measuredRows(scene: SceneComparison | undefined): RidgeRow[] {
  return (scene?.arms ?? []).flatMap(({ arm, after }): RidgeRow[] => {
    const known = (['live', 'lane'] as const).filter((measured) => after?.[measured]);
    return known.map((measured) => ({ arm, label: `${arm} ${measured}`, posterior: after![measured]!, measured, ...(known.length > 1 && { isPart: true as const }) }));
  });
}

/** Returns a row per arm: its posterior from all builds, drawn over its posterior from the earlier builds. */
function priorRows(scene: SceneComparison | undefined): RidgeRow[] {
  return (scene?.arms ?? []).flatMap(({ arm, before, after }): RidgeRow[] => (after?.posterior
    ? [{ arm, label: arm, posterior: after.posterior, measured: after.live ? 'live' : 'lane', ...(before?.posterior && { before: before.posterior }) }] : []));
}

const csvOf = ({ project, scene }: SceneName) => csvUrl('evidence', { project, scene, withWeights: true });

function ByMeasure({ scene, name }: { scene: SceneComparison | undefined; name: SceneName }) {
  return (
    <RidgeFigure id="measured" title="Measured in games, and in the shadow lane" names={[name.project, name.scene]} rows={measuredRows(scene)} csvHref={csvOf(name)}
      rewardVersion={name.rewardVersion} notYet={NO_EVIDENCE}
      note="Games run an algorithm when the policy chooses it. The lane runs all algorithms on the same frames, on a thread of its own. For some of them its costs are wrong by 10 to 20 %.
        Posteriors compare the algorithms by their costs in the lane, scaled to the mean cost of the algorithms that also ran in games. A posterior may therefore differ from both
        measurements." />
  );
}

function ByBuild({ builds, name }: { builds: readonly string[]; name: SceneName }) {
  const asked = route.value.query.get('build');
  const build = asked !== null && builds.includes(asked) ? asked : builds[0] ?? '';
  const reading = useList(PriorsService.method.compareBuilds, { project: name.project, scene: name.scene, before: { build, others: true } });
  const shown = <Name text={build || 'unknown'} />;
  const figure = (rows: RidgeRow[]) => (
    <RidgeFigure id="build" title="Prior and posterior of a build" names={[name.project, name.scene, build]} csvHref={csvOf(name)} rows={rows} rewardVersion={name.rewardVersion} notYet={NO_EVIDENCE}
      note={builds.length > 1
        ? <>Dashed grey: the evidence of the other builds alone. Filled: the evidence of all builds, including build {shown}, from games and from the shadow lane.</>
        : <>Only build {shown} has evidence of this scene.</>}>
      {builds.length > 1 && <Choice label="Build" parameter="build" options={builds.map((each) => [each, visible(each) || 'unknown'] as const)} />}
    </RidgeFigure>
  );
  return <Read reading={reading} what="the evidence of builds">{(parts) => figure(priorRows(find(parts, name)))}</Read>;
}

function Evidence({ name }: { name: SceneName }) {
  const both = (scene: SceneComparison | undefined) => (
    <div class="beside"><ByMeasure scene={scene} name={name} /><ByBuild builds={scene?.builds ?? []} name={name} /></div>
  );
  const reading = useList(PriorsService.method.compareBuilds, { project: name.project, scene: name.scene });
  return <Read reading={reading} what="the evidence">{(parts) => both(find(parts, name))}</Read>;
}

export function SceneEvidence({ name }: { name: SceneName }) {
  const [isOpen, open] = useState(false);
  if (isOpen) return <Evidence name={name} />;
  return <p><button type="button" onClick={() => open(true)}>Show evidence by source</button> <span class="soft">This compares the stored evidence of games, of the shadow lane, and of each build.</span></p>;
}
