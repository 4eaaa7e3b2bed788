// The frame times of a session, from its latest decisions.
import type { DecisionEvent } from '../../gen/sweepstake/v1/posteriors_pb';
import { NS_PER_MS } from '../numbers/log_cost';
import { bucketsOf, percentile } from '../numbers/histogram';
import { once } from './once';
import type { SessionState } from './sessions';

const frameTimeMs = once(({ measurements }: DecisionEvent): number | undefined => {
  const ns = measurements?.frameTimeNs && percentile(bucketsOf(measurements.frameTimeNs), 0.5);
  return ns === undefined ? undefined : ns / NS_PER_MS;
});

const MAX_TIMES = 60;

/** Returns the median frame time before each of the session's latest decisions in milliseconds, oldest first. */
export const frameTimesOf = (session: Pick<SessionState, 'decisions'> | undefined): number[] =>
  (session?.decisions.slice(-MAX_TIMES) ?? []).map(frameTimeMs).filter((ms) => ms !== undefined);
