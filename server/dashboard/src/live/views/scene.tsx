// The view of a scene: the posterior of each arm, its history, and the evidence for it.
import { useComputed } from '@preact/signals';
import { useEffect, useMemo, useRef } from 'preact/hooks';
import { counted } from '../../format';
import type { Moment } from '../charts/plot';
import { RidgeFigure } from '../charts/ridgeline';
import { TimeTools } from '../charts/time_chart';
import { useFrozen } from '../charts/view_state';
import { mean } from '../numbers/beta';
import { LOG_COST_REWARD_VERSION } from '../numbers/log_cost';
import { csvUrl } from '../parts/download';
import { ago, now } from '../parts/clock';
import { CopyLink } from '../parts/toast';
import { Name, visible } from '../parts/name';
import { Empty, Failure, Loading } from '../parts/states';
import { HistoryKind } from '../../gen/sweepstake/v1/history_pb';
import type { ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { connection } from '../state/connection';
import { areScenesKnown } from '../state/live';
import { decisionsHref, route, sceneHref, sceneNameOf } from '../state/route';
import { sceneInView, sceneKey, scenes, type SceneName, type SceneState } from '../state/scenes';
import { urlOf } from '../transport/calls';
import { type HistoryReading, selectionOf, useHistory, WHOLE_LIFE } from '../transport/history';
import { OverTime } from './over_time';
import { CompareScenes } from './compare';
import { BuildChange, Builds, Latest, Sessions, Variants, variantsOf } from './scene/lists';
import { type ArmRow, armRows, ArmTable, latestSwitches, MAX_SWITCHES, ridgeRows } from './scene/arms';
import { SceneEvidence } from './scene/evidence';
import { bestDiffer } from '../state/regimes';
import { Headline, Regimes } from './scene/headline';
import { RegimeCosts } from './scene/regime_costs';

function Facts({ state }: { state: SceneState }) {
  const { posterior, changedMs } = state;
  const policy = state.decisions.at(-1)?.policy;
  return (
    <dl class="facts">
      <div><dt>Machines</dt><dd><Name text={posterior.machineClass} /></dd></div>
      {posterior.rewardVersion !== LOG_COST_REWARD_VERSION && <div><dt>Reward</dt><dd>version {posterior.rewardVersion}</dd></div>}
      <div><dt>Now</dt><dd>{counted(posterior.activeSessionCount, 'session', 'sessions')}</dd></div>
      <div><dt>Evidence from</dt><dd>{counted(Number(posterior.sourceCount), 'session', 'sessions')}</dd></div>
      <div><dt>Last change</dt><dd>{changedMs ? ago(changedMs, now.value) : 'unknown'}</dd></div>
      {policy && <div><dt>Policy</dt><dd><Name text={policy} /></dd></div>}
    </dl>
  );
}

const csvOf = ({ project, scene }: Pick<SceneName, 'project' | 'scene'>) => csvUrl('scenes', { project, scene });

function Beliefs({ rows, state: { posterior }, before }: { rows: readonly ArmRow[]; state: SceneState; before: ScenePosterior }) {
  const ridges = useMemo(() => ridgeRows(rows, before), [rows]);
  const table = () => ({
    header: ['algorithm', 'backend version', 'measured', 'alpha', 'beta', 'mean reward', 'reward 95 % from', 'to', 'P(best)', 'cost ratio', 'windows', 'lane visits', 'equivalent windows', 'bail-outs'],
    rows: rows.map(({ arm, backendVersion, measured, posterior: beta, costRatio, ...row }) => [arm, backendVersion, measured, beta.alpha, beta.beta, mean(beta),
      beta.low95, beta.high95, row.bestProbability, costRatio?.median, row.windowCount, row.visitCount, row.effectiveWindowCount, row.bailOutCount]),
  });
  return (
    <RidgeFigure id="beliefs" title="Posterior of each algorithm" names={[posterior.project, posterior.scene]} table={table} csvHref={csvOf(posterior)} rows={ridges}
      rewardVersion={posterior.rewardVersion} notYet="No algorithm has evidence yet."
      note="Thick lines are 50 % credible intervals, thin ones 95 %. Algorithms with a dashed outline never ran in a game. Dashed grey: the posterior when you opened this view, if it
        has changed since. The prior of a build is below, under Evidence; the prior of a session is in the view of that session." />
  );
}

function Charts({ state: { posterior, decisions }, builds: { series } }: { state: SceneState; builds: HistoryReading }) {
  const moments = useMemo(() => [...latestSwitches(decisions), ...series.filter(({ build }) => build !== '')
    .map(({ build, points }): Moment => ({ timeMs: Number(points[0]!.unixMs), colour: 'var(--soft)', label: visible(build).slice(0, 20) }))], [decisions, series]);
  return (
    <>
      <TimeTools />
      <p class="soft small">Dotted lines mark the first session of each build. They also mark the latest {MAX_SWITCHES} switches of all sessions, in the colour of the new algorithm.</p>
      <OverTime selection={selectionOf(HistoryKind.SCENE, posterior)} names={[posterior.project, posterior.scene]} moments={moments} />
    </>
  );
}

function Scene({ state: latest, name }: { state: SceneState; name: SceneName }) {
  const state = useFrozen(latest, true);
  const before = useRef(latest.posterior).current;
  const rows = useMemo(() => armRows(state.posterior), [state]);
  const { activity } = state.posterior;
  const builds = useHistory(selectionOf(HistoryKind.BUILD, name), WHOLE_LIFE);
  const beliefs = <><Beliefs rows={rows} state={state} before={before} /><ArmTable rows={rows} rewardVersion={name.rewardVersion} csvHref={csvOf(name)} /></>;
  return (
    <>
      <header class="title"><h1><span class="soft"><Name text={name.project} /> /</span> <Name text={name.scene} /></h1><CopyLink /></header>
      <Headline state={state} />
      <BuildChange builds={builds} />
      <Facts state={state} />
      <section aria-labelledby="regimes-heading"><h2 id="regimes-heading">Regimes</h2><Regimes posterior={state.posterior} /></section>
      {activity && bestDiffer(state.posterior) ? (
        <>
          <RegimeCosts activity={activity} posterior={state.posterior} />
          <details>
            <summary>All regimes together</summary>
            <p class="soft small">These posteriors average the logarithms of all costs, so they do not say which single choice is the best: a rare regime with high costs counts little.</p>
            {beliefs}
          </details>
        </>
      ) : beliefs}
      <section aria-labelledby="time-heading"><h2 id="time-heading">Over time</h2><Charts state={state} builds={builds} /></section>
      <section aria-labelledby="evidence-heading"><h2 id="evidence-heading">Evidence</h2><SceneEvidence name={name} /></section>
      <section aria-labelledby="classes-heading"><h2 id="classes-heading">Comparison of machines</h2><Variants name={name} /></section>
      <section aria-labelledby="builds-heading"><h2 id="builds-heading">Comparison of builds</h2><Builds name={name} builds={builds} /></section>
      <section aria-labelledby="sessions-heading"><h2 id="sessions-heading">Sessions</h2><Sessions name={name} /></section>
      <section aria-labelledby="latest-heading"><h2 id="latest-heading">Latest decisions</h2><Latest decisions={state.decisions} rewardVersion={name.rewardVersion} />
        <p><a href={decisionsHref({ project: name.project, scene: name.scene })}>All decisions of this scene</a></p></section>
    </>
  );
}

function NoScene({ name }: { name: SceneName }) {
  const others = variantsOf(name);
  const { error } = connection.value;
  if (!areScenesKnown.value) return error ? <Failure what="The scene" error={error} onRetry={() => location.reload()} /> : <Loading what="the scene" />;
  return (
    <Empty title="The daemon does not know this scene">
      <p><Name text={name.project} /> / <Name text={name.scene} /> on <Name text={name.machineClass} />, reward version {name.rewardVersion}.</p>
      {others.map(({ key, posterior }) => (
        <p key={key}><a href={sceneHref(posterior)}>on <Name text={posterior.machineClass} />, reward version {posterior.rewardVersion}</a></p>
      ))}
      <p><a href={urlOf('/')}>All scenes</a></p>
    </Empty>
  );
}

function Opened({ name, other }: { name: SceneName; other: string | null }) {
  const key = sceneKey(name);
  const state = useComputed(() => scenes.value.get(key)).value; // redraws only if this scene changes
  useEffect(() => {
    sceneInView.value = key;
    return () => { sceneInView.value = ''; };
  }, [key]);
  if (!state) return <NoScene name={name} />;
  return other ? <CompareScenes own={state} other={other} /> : <Scene state={state} name={name} />;
}

export function SceneView() {
  const name = sceneNameOf(route.value);
  const other = route.value.query.get('with');
  return <Opened key={`${sceneKey(name)}\n${other ?? ''}`} name={name} other={other} />;
}
