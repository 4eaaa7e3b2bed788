// What the choice of algorithms saves in the scenes that are played now, and their frame times.
import type { DecisionEvent, ScenePosterior } from '../../gen/sweepstake/v1/posteriors_pb';
import { mean } from '../../format';
import { NS_PER_MS } from '../numbers/log_cost';
import { bucketsOf, percentile } from '../numbers/histogram';
import { once } from './once';
import type { SessionState } from './sessions';

/** Means over scenes, in microseconds per frame. */
export interface Savings {
  sceneCount: number; // scenes with a session that has measured what it saves
  ranUs: number; // detection time of what ran, with the cost of switches
  // Saved against the algorithm that each game begins with, the best single algorithm of each scene, and KDTree.
  // Absent: some scene does not know it.
  againstInitialUs?: number;
  againstSingleUs: number;
  againstReferenceUs?: number;
}

/** Returns the mean savings of the scenes that are played now; undefined if none has measured them yet. */
export function savingsOf(posteriors: readonly Pick<ScenePosterior, 'activity'>[]): Savings | undefined {
  const totals = posteriors.map(({ activity }) => activity?.total)
    .filter((total) => total?.ranUs !== undefined && total.savedAgainstSingleUs !== undefined).map((total) => total!);
  if (totals.length === 0) return undefined;
  const meanOf = (values: (number | undefined)[]) => {
    const known = values.filter((us) => us !== undefined);
    return known.length === totals.length ? mean(known) : undefined;
  };
  const [initial, reference] = [meanOf(totals.map((total) => total.savedAgainstInitialUs)), meanOf(totals.map((total) => total.savedAgainstReferenceUs))];
  return {
    sceneCount: totals.length,
    ranUs: mean(totals.map(({ ranUs }) => ranUs!)),
    againstSingleUs: mean(totals.map(({ savedAgainstSingleUs }) => savedAgainstSingleUs!)),
    ...(initial !== undefined && { againstInitialUs: initial }),
    ...(reference !== undefined && { againstReferenceUs: reference }),
  };
}

const frameTimeMs = once(({ measurements }: DecisionEvent): number | undefined => {
  const ns = measurements?.frameTimeNs && percentile(bucketsOf(measurements.frameTimeNs), 0.5);
  return ns === undefined ? undefined : ns / NS_PER_MS;
});

const MAX_TIMES = 60;

/** Returns the median frame time before each of the session's latest decisions in milliseconds, oldest first. */
export const frameTimesOf = (session: Pick<SessionState, 'decisions'> | undefined): number[] =>
  (session?.decisions.slice(-MAX_TIMES) ?? []).map(frameTimeMs).filter((ms) => ms !== undefined);
