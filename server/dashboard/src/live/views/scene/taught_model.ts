// The evidence of a scene as rows of charts: by what it was measured, and what one build adds to that of all others.
import type { RidgeRow } from '../../charts/ridgeline';
import type { Beta } from '../../numbers/beta';
import { type ArmEvidence, evidenceByArm, pooled, type Sum, type Taught } from '../../numbers/priors_diff';
import type { SceneName } from '../../state/scenes';

/** Returns what was taught of a scene on its class of machines by its version of the reward, in the newest version of each arm. */
function taughtIn<Part extends Taught>(taught: Iterable<Part>, { machineClass, rewardVersion }: SceneName): Part[] {
  const own = [...taught].filter(({ example }) => example.machineClass === machineClass && example.rewardVersion === rewardVersion);
  const newest = new Map<string, number>();
  for (const { example: { arm, backendVersion } } of own) newest.set(arm, Math.max(newest.get(arm) ?? 0, backendVersion));
  return own.filter(({ example }) => example.backendVersion === newest.get(example.arm));
}

const flatAnd = ({ alpha, beta }: Sum): Beta => ({ alpha: 1 + alpha, beta: 1 + beta });
const isKnown = ({ alpha, beta }: Sum) => alpha + beta > 0;

/** Returns a row per arm and way of measuring, an arm's two beside one another. */
export function measuredRows(taught: Iterable<Taught>, name: SceneName): RidgeRow[] {
  const arms = [...evidenceByArm(taughtIn(taught, name))].sort(([a], [b]) => a.localeCompare(b));
  return arms.flatMap(([arm, sums]): RidgeRow[] => {
    const known = (['live', 'lane'] as const).filter((measured) => isKnown(sums[measured]));
    return known.map((measured) => ({ arm, label: `${arm} ${measured}`, posterior: flatAnd(sums[measured]), measured, ...(known.length > 1 && { isPart: true as const }) }));
  });
}

/** Returns the builds that taught something of a scene; '' is one that is unknown. */
export const buildsIn = (taught: Iterable<Taught>, name: SceneName): string[] => [...new Set(taughtIn(taught, name).map(({ example }) => example.build))];

const sumsByArm = (arms: ReadonlyMap<string, ArmEvidence>) => {
  const sums = pooled([...arms.values()]);
  return new Map([...arms.keys()].map((arm, i) => [arm, sums[i]!] as const));
};

/** Returns what all builds taught of each arm, windows and visits together, and before it what the others than `build` did. */
export function priorRows(taught: Iterable<Taught>, name: SceneName, build: string): RidgeRow[] {
  const own = taughtIn(taught, name);
  const arms = evidenceByArm(own);
  const others = sumsByArm(evidenceByArm(own.filter(({ example }) => example.build !== build)));
  return [...sumsByArm(arms)].sort(([a], [b]) => a.localeCompare(b)).map(([arm, sum]): RidgeRow => {
    const before = others.get(arm);
    return { arm, label: arm, posterior: flatAnd(sum), measured: isKnown(arms.get(arm)!.live) ? 'live' : 'lane', ...(before && isKnown(before) && { before: flatAnd(before) }) };
  });
}
