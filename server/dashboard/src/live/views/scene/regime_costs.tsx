// The costs of the algorithms in each regime of a scene, one chart per regime.
import { significant } from '../../../format';
import type { RegimePosterior, SceneActivity, ScenePosterior } from '../../../gen/sweepstake/v1/posteriors_pb';
import { ChartFrame } from '../../charts/frame';
import { Intervals } from '../../charts/intervals';
import { visible } from '../../parts/name';
import { bestOf, regimeText } from '../../state/regimes';

function Regime({ regime, number, activity, names }: { regime: RegimePosterior; number: number; activity: SceneActivity; names: readonly string[] }) {
  const known = activity.arms.map((arm, i) => ({ arm, belief: regime.arms[i] })).filter(({ belief }) => belief && belief.costUs > 0)
    .sort((a, b) => a.belief!.costUs - b.belief!.costUs);
  const rows = known.map(({ arm, belief }) => ({ arm, before: undefined, after: { median: belief!.costUs, low: belief!.lowUs, high: belief!.highUs } }));
  const best = bestOf(regime, activity);
  const title = `Regime ${number}${regime.isPresent ? ' (now)' : ''}${best ? `: ${visible(regime.bestArm)}, P(best) ${best.bestProbability.toFixed(3)}` : ''}`;
  const table = () => ({
    header: ['algorithm', 'cost (µs)', '95 % from (µs)', 'to (µs)', 'P(best)'],
    rows: known.map(({ arm, belief }) => [arm, belief!.costUs, belief!.lowUs, belief!.highUs, belief!.bestProbability]),
  });
  return (
    <ChartFrame id={`regime-${number}`} title={title} names={names} table={table} empty={rows.length === 0 && 'No costs are known: nothing was measured, or the policy does not estimate costs.'}
      note={<>{regimeText(regime)}. Estimate and 95 % interval of the mean detection time per frame.</>}>
      <Intervals title={title} rows={rows} unit="µs per frame (less is better)" format={(us) => `${significant(us)} µs`} />
    </ChartFrame>
  );
}

/** REQUIRES: the session has seen several regimes. */
export const RegimeCosts = ({ activity, posterior: { project, scene } }: { activity: SceneActivity; posterior: ScenePosterior }) => (
  <div class="beside">
    {activity.regimes.map((regime, i) => <Regime key={i} regime={regime} number={i + 1} activity={activity} names={[project, scene]} />)}
  </div>
);
