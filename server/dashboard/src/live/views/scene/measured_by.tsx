// What the frame thread of games and what the shadow lane taught, told apart: the evidence of all sources, read when it is asked for.
import { useState } from 'preact/hooks';
import { PriorsService } from '../../../gen/sweepstake/v1/priors_pb';
import { ChartFrame } from '../../charts/frame';
import { Ridgeline, type RidgeRow } from '../../charts/ridgeline';
import { centralInterval, mean } from '../../numbers/beta';
import { LOG_COST_REWARD_VERSION, rewardText } from '../../numbers/log_cost';
import { Failure, Loading } from '../../parts/states';
import { addPart, type Evidence, type EvidenceSum, noEvidence } from '../../state/evidence';
import type { SceneName } from '../../state/scenes';
import { type ApiError, asApiError, stream } from '../../transport/calls';

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

/** Returns a row per arm and way of measuring, an arm's two beside one another. */
export function measuredRows(sums: Iterable<EvidenceSum>, { machineClass, rewardVersion }: SceneName): RidgeRow[] {
  return [...sums].filter(({ example }) => example.machineClass === machineClass && example.rewardVersion === rewardVersion)
    .sort((a, b) => a.example.arm.localeCompare(b.example.arm) || a.example.measuredBy.localeCompare(b.example.measuredBy))
    .map(({ example, alpha, beta }): RidgeRow => {
      const isLane = example.measuredBy !== '';
      return { arm: example.arm, label: `${example.arm} ${isLane ? example.measuredBy : 'live'}`, posterior: { alpha: 1 + alpha, beta: 1 + beta }, measured: isLane ? 'lane' : 'live' };
    });
}

function Rows({ evidence, name }: { evidence: Evidence; name: SceneName }) {
  const rows = measuredRows(evidence.sums.values(), name);
  const title = 'Measured in games, and in the shadow lane';
  const text = (reward: number) => rewardText(reward, name.rewardVersion === LOG_COST_REWARD_VERSION);
  const table = () => ({
    header: ['arm', 'measured', 'mean', '95 % from', 'to', 'alpha', 'beta'],
    rows: rows.map(({ arm, measured, posterior }) => [arm, measured, text(mean(posterior)), ...centralInterval(posterior, 0.95).map(text), posterior.alpha, posterior.beta]),
  });
  return (
    <ChartFrame id="measured" title={title} names={[name.project, name.scene]} table={table} empty={rows.length === 0 && 'Nothing is stored of this scene yet.'}
      note="The lane runs off the frame thread and is off by 10 to 20 % for some arms; where both know an arm they should be near one another.">
      <Ridgeline title={title} rows={rows} rewardVersion={name.rewardVersion} />
      {evidence.foldedRecordCount > 0 && <p class="soft">{evidence.foldedRecordCount} records of old sessions, which the daemon has folded together, are left out.</p>}
    </ChartFrame>
  );
}

export function MeasuredBy({ name }: { name: SceneName }) {
  const [answer, setAnswer] = useState<Answer>(undefined);
  const load = () => {
    setAnswer('loading');
    void read(name).then(setAnswer);
  };
  if (answer === undefined) return <p><button type="button" onClick={load}>Tell live and lane apart</button> <span class="soft">reads the scene’s evidence once</span></p>;
  if (answer === 'loading') return <Loading what="the evidence" />;
  return 'error' in answer ? <Failure what="The evidence" error={answer.error} onRetry={load} /> : <Rows evidence={answer.evidence} name={name} />;
}
