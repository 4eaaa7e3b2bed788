// What sessions ran and saved, from points of the history. The daemon defines the sums (history.proto).
import type { HistoryPoint } from '../../gen/sweepstake/v1/history_pb';
import { bucketsOf, countOf, middleOf } from './histogram';

export const REFERENCE_ARM = 'KDTree'; // kReferenceArm in regime_report.h

/** Sums over frames, in microseconds. An absent saving is not known. */
export interface Use {
  frameCount: number; // measured frames
  ranUs: number;
  againstInitialUs?: number; // saved against the algorithm with which the games begin
  againstSingleUs?: number; // saved against the best single algorithm
  againstReferenceUs?: number; // saved against KDTree
  frameUs: number; // time of as many whole frames
}

type Point = Pick<HistoryPoint, 'frameCount' | 'ranUs' | 'initialUs' | 'initialKnownFrameCount' | 'arms' | 'frameTimeNs'>;

// Whether a cost was known in most of the frames, as IsMostlyKnown in regime_report.h.
const isMostlyKnown = (knownCount: bigint, { frameCount }: Point) => 2n * knownCount > frameCount;

/** Returns what the point's sessions ran and saved; undefined without measured frames. */
export function measuredIn(point: Point): Use | undefined {
  const frameCount = Number(point.frameCount);
  if (frameCount === 0) return undefined;
  const costs = point.arms.filter((arm) => arm.frameCount === point.frameCount && isMostlyKnown(arm.knownFrameCount, point)); // arms that all sessions have
  const reference = costs.find(({ arm }) => arm === REFERENCE_ARM);
  return {
    frameCount,
    ranUs: point.ranUs,
    frameUs: (frameCount * meanNs(point)) / 1000,
    ...(isMostlyKnown(point.initialKnownFrameCount, point) && { againstInitialUs: point.initialUs - point.ranUs }),
    ...(costs.length > 0 && { againstSingleUs: Math.min(...costs.map(({ wouldTakeUs }) => wouldTakeUs)) - point.ranUs }),
    ...(reference && { againstReferenceUs: reference.wouldTakeUs - point.ranUs }),
  };
}

function meanNs({ frameTimeNs }: Point): number {
  const buckets = bucketsOf(frameTimeNs ?? { bucketSteps: [], counts: [] });
  let sum = 0;
  for (const [bucket, count] of buckets) sum += count * middleOf(bucket);
  return sum / Math.max(1, countOf(buckets));
}

/** The savings, and against what they are. */
export const SAVINGS = [
  ['againstInitialUs', 'the algorithm that each game begins with'], ['againstSingleUs', 'the best single algorithm'], ['againstReferenceUs', REFERENCE_ARM],
] as const;

/** Returns each known saving: per frame in µs, as a share of the frame time, and against what it is. */
export const savingsOf = (use: Use) => SAVINGS.flatMap(([part, against]) =>
  (use[part] === undefined ? [] : [{ us: use[part] / use.frameCount, ratio: use[part] / use.frameUs, against }]));

/** Adds up what several points, scenes or builds saved against the algorithms with which their games begin. Leaves out those that do not
 * know that; undefined if none does. Another saving that one of them does not know is absent. */
export function sumOf(uses: readonly (Use | undefined)[]): Use | undefined {
  const known = uses.filter((use) => use?.againstInitialUs !== undefined) as Use[];
  if (known.length === 0) return undefined;
  const total = (part: keyof Use) => known.reduce((sum, use) => sum + (use[part] ?? Number.NaN), 0);
  const savings = SAVINGS.map(([part]) => [part, total(part)] as const).filter(([, us]) => !Number.isNaN(us));
  return { frameCount: total('frameCount'), ranUs: total('ranUs'), frameUs: total('frameUs'), ...Object.fromEntries(savings) };
}
