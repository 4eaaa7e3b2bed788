// Who and what taught a scene its beliefs: the evidence of all sources, read when it is asked for. What the frame thread of games and what
// the shadow lane measured, told apart; and what a build found against what the others had taught before it.
import { useState } from 'preact/hooks';
import { PriorsService } from '../../../gen/sweepstake/v1/priors_pb';
import { ChartFrame } from '../../charts/frame';
import { Ridgeline } from '../../charts/ridgeline';
import { type Beta, centralInterval, mean } from '../../numbers/beta';
import { LOG_COST_REWARD_VERSION, rewardText } from '../../numbers/log_cost';
import { Choice } from '../../parts/filter';
import { Name } from '../../parts/name';
import { Failure, Loading } from '../../parts/states';
import { visible } from '../../parts/visible';
import { addPart, type Evidence, noEvidence } from '../../state/evidence';
import { route } from '../../state/route';
import type { SceneName } from '../../state/scenes';
import { type ApiError, asApiError, stream } from '../../transport/calls';
import { buildsIn, measuredRows, priorRows } from './taught_model';

type Answer = { evidence: Evidence } | { error: ApiError } | 'loading' | undefined;

async function read({ project, scene }: SceneName): Promise<Answer> {
  const evidence = noEvidence();
  try {
    for await (const part of stream(PriorsService.method.exportPriors, { project, scene })) addPart(evidence, part);
    return { evidence };
  } catch (error) {
    return { error: asApiError(error) };
  }
}

const textOf = ({ rewardVersion }: SceneName) => (reward: number) => rewardText(reward, rewardVersion === LOG_COST_REWARD_VERSION);

function ByMeasure({ evidence, name }: { evidence: Evidence; name: SceneName }) {
  const rows = measuredRows(evidence.sums.values(), name);
  const title = 'Measured in games, and in the shadow lane';
  const text = textOf(name);
  const ends = (posterior: Beta) => {
    const [low, high] = centralInterval(posterior, 0.95);
    return name.rewardVersion === LOG_COST_REWARD_VERSION ? [high, low] : [low, high]; // the highest reward is the least cost
  };
  const table = () => ({
    header: ['arm', 'measured', 'mean', '95 % from', 'to', 'alpha', 'beta'],
    rows: rows.map(({ arm, measured, posterior }) => [arm, measured, text(mean(posterior)), ...ends(posterior).map(text), posterior.alpha, posterior.beta]),
  });
  return (
    <ChartFrame id="measured" title={title} names={[name.project, name.scene]} table={table} empty={rows.length === 0 && 'Nothing is stored of this scene yet.'}
      note="Games run an arm when the policy chose it; the lane runs all arms on the same frames, off the frame thread, and is off by 10 to 20 % for some. Beliefs take from the lane
        how arms compare and from games the level, the mean over the arms that both know: one may lie beside both of its measurements here.">
      <Ridgeline title={title} rows={rows} rewardVersion={name.rewardVersion} />
    </ChartFrame>
  );
}

const BUILD = 'build'; // in the address

function ByBuild({ evidence, name }: { evidence: Evidence; name: SceneName }) {
  const lastSeenS = (build: string) => evidence.builds.get(`${name.project}\n${build}`)?.lastSeenS ?? 0;
  const builds = buildsIn(evidence.sums.values(), name).sort((a, b) => lastSeenS(b) - lastSeenS(a) || a.localeCompare(b));
  const asked = route.value.query.get(BUILD);
  const build = asked !== null && builds.includes(asked) ? asked : builds[0] ?? '';
  const rows = priorRows(evidence.sums.values(), name, build);
  const title = 'Prior and posterior of a build';
  const text = textOf(name);
  const shown = <Name text={build || 'unknown'} />;
  const table = () => ({
    header: ['arm', 'mean', 'alpha', 'beta', 'prior mean', 'prior alpha', 'prior beta'],
    rows: rows.map(({ arm, posterior, before }) => [arm, ...[posterior, before].flatMap((beta) => [beta && text(mean(beta)), beta?.alpha, beta?.beta])]),
  });
  return (
    <ChartFrame id="build" title={title} names={[name.project, name.scene, build]} table={table} empty={rows.length === 0 && 'Nothing is stored of this scene yet.'}
      note={builds.length > 1
        ? <>Dashed grey: what the other builds taught, where they know the arm; filled: that and what build {shown} taught, windows and visits together.</>
        : <>Only build {shown} taught something here: before it nothing was known of any arm.</>}>
      {builds.length > 1 && <Choice label="Build" parameter={BUILD} options={builds.map((each) => [each, visible(each) || 'unknown'] as const)} />}
      <Ridgeline title={title} rows={rows} rewardVersion={name.rewardVersion} />
    </ChartFrame>
  );
}

export function Taught({ name }: { name: SceneName }) {
  const [answer, setAnswer] = useState<Answer>(undefined);
  const load = () => {
    setAnswer('loading');
    void read(name).then(setAnswer);
  };
  if (answer === undefined) return <p><button type="button" onClick={load}>Tell sources apart</button> <span class="soft">reads the scene’s evidence once: live against lane, and a build against those before it</span></p>;
  if (answer === 'loading') return <Loading what="the evidence" />;
  if ('error' in answer) return <Failure what="The evidence" error={answer.error} onRetry={load} />;
  const { evidence } = answer;
  return (
    <>
      <div class="beside"><ByMeasure evidence={evidence} name={name} /><ByBuild evidence={evidence} name={name} /></div>
    </>
  );
}
