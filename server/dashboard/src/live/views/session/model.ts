// The data of a session's charts and tables, computed from the steps of its log.
import type { Measured as MeasuredBy, RidgeRow } from '../../charts/ridgeline';
import type { Moment } from '../../charts/plot';
import type { Range } from '../../charts/view_state';
import { armStyle } from '../../charts/colours';
import { AuditKind } from '../../../gen/sweepstake/v1/audit_pb';
import { forEachVisit, isSwitch, percentilesOf, type Step, windowOf } from '../../audit/steps';
import { ShadowFlag } from '../../../gen/sweepstake/v1/telemetry_pb';
import type { Beta } from '../../numbers/beta';
import { keepExtremes } from '../../numbers/downsample';
import type { SeriesRow } from '../../charts/posterior_charts';

const MAX_POINTS = 600;

/** Returns the steps in the range and one on each side of it, so that lines reach its ends. */
export function stepsIn(shown: Range | undefined, steps: readonly Step[]): readonly Step[] {
  if (!shown) return steps;
  const [first, end] = [steps.findIndex(({ timeMs }) => timeMs >= shown.fromMs), steps.findLastIndex(({ timeMs }) => timeMs <= shown.toMs)];
  return first < 0 ? [] : steps.slice(Math.max(0, first - 1), end + 2);
}

/** Returns the posterior of each arm after a step of the log; empty if the step's row has none. */
const posteriorsOf = ({ placed }: Step): readonly Beta[] => placed?.row.decision?.posteriors ?? [];

const bestOf = ({ placed, event }: Step): readonly number[] => event?.bestProbability ?? placed?.row.decision?.bestProbability ?? [];

/** Returns the posteriors after decisions, for at most about MAX_POINTS decisions. */
export function beliefRows(steps: readonly Step[], armCount: number): SeriesRow[] {
  const told = steps.filter((step) => step.told && bestOf(step).length === armCount);
  const timesMs = told.map(({ timeMs }) => timeMs);
  const columns = Array.from({ length: armCount }, (_, arm) => told.map((step) => bestOf(step)[arm] ?? null));
  const lastKnown = told.findLastIndex((step) => posteriorsOf(step).length > 0); // the last decision with posteriors, where the lines end
  const kept = new Set(keepExtremes(timesMs, columns, MAX_POINTS));
  if (lastKnown >= 0) kept.add(lastKnown);
  return [...kept].sort((a, b) => a - b).map((i) => {
    const step = told[i]!;
    const posteriors = posteriorsOf(step);
    return {
      timeMs: step.timeMs,
      beliefs: Array.from({ length: armCount }, (_, arm) => posteriors[arm]),
      best: [...bestOf(step)],
    };
  });
}

function measuredBy(arm: string, live: ReadonlySet<string>, lane: ReadonlySet<string>, isChanged: boolean): MeasuredBy {
  if (live.has(arm)) return 'live';
  return lane.has(arm) ? 'lane' : isChanged ? 'live' : 'never';
}

/** Returns the latest posterior of each arm and its prior. Without the session's beginning, an arm whose posterior changed counts as measured. */
export function priorAndPosterior(steps: readonly Step[], arms: readonly string[]): RidgeRow[] {
  const last = steps.findLast((step) => posteriorsOf(step).length === arms.length);
  if (!last) return [];
  const priors = steps.find(({ placed }) => placed?.setup)?.placed?.setup?.priors ?? [];
  const live = new Set(steps.map(({ placed }) => arms[placed?.row.decision?.increment?.arm ?? -1] ?? ''));
  const lane = new Set<string>();
  forEachVisit(steps, (arm) => lane.add(arm));
  const isWhole = steps[0]?.placed?.row.row === 1n;
  return posteriorsOf(last).map((posterior, i) => {
    const arm = arms[i]!;
    const before = priors[i];
    const isChanged = !isWhole && (posterior.alpha !== (before?.alpha ?? 1) || posterior.beta !== (before?.beta ?? 1));
    return { arm, label: arm, posterior, ...(before && { before }), measured: measuredBy(arm, live, lane, isChanged) };
  });
}

export function switchMoments(steps: readonly Step[], arms: readonly string[]): Moment[] {
  const moments: Moment[] = [];
  let before = '';
  for (const { activeArm, timeMs } of steps) {
    if (!activeArm || activeArm === before) continue;
    if (before) moments.push({ timeMs, colour: armStyle(activeArm, arms).colour });
    before = activeArm;
  }
  return moments;
}

const orNull = (value: number | undefined) => (value === undefined || Number.isNaN(value) ? null : value);

// Forward fill: a sparse value holds until the next one.
function held(values: (number | null)[]): (number | null)[] {
  let latest: number | null = null;
  return values.map((value) => (latest = value ?? latest));
}

type Part = 'frameMs' | 'detectionMs' | 'nativeBytes';

/** The costs of a session's frames as columns of charts. Above MAX_POINTS points, only extremes are kept. */
export type CostColumns = ReturnType<typeof costColumns>;
export function costColumns(steps: readonly Step[]) {
  const all = steps.filter(({ kind, placed, event }) => event?.measurements || (placed && kind === AuditKind.TICK)).map(({ timeMs, placed, event }) =>
    ({ timeMs, frames: event?.measurements && percentilesOf(event.measurements), window: placed && windowOf(placed.row), scene: placed?.row.scene }));
  const worst = (part: Part) => all.map(({ frames, window }) => orNull(frames?.[part]?.[2] ?? window?.[part]));
  const kept = keepExtremes(all.map(({ timeMs }) => timeMs), [worst('frameMs'), worst('detectionMs')], MAX_POINTS).map((i) => all[i]!);
  const columns = (part: Part) => // mean (peak of bytes), p50, p95, p99
    [kept.map(({ window }) => orNull(window?.[part])), ...[0, 1, 2].map((place) => kept.map(({ frames }) => orNull(frames?.[part]?.[place])))];
  return {
    timesMs: kept.map(({ timeMs }) => timeMs),
    frame: columns('frameMs'),
    detection: columns('detectionMs').map((values) => values.map((ms) => ms && 1000 * ms)), // µs
    bytes: columns('nativeBytes'),
    checks: kept.map(({ window }) => orNull(window?.checkCount)),
    objects: held(kept.map(({ scene }) => orNull(scene?.objectCount))),
  };
}

export interface LaneSum { arm: string; visitCount: number; cappedCount: number; medianNs: number; lastNs: number; buildNs: number; lastMs: number }

const medianOf = (values: readonly number[]) => Float64Array.from(values).sort()[Math.floor((values.length - 1) / 2)] ?? 0;

export function laneSums(steps: readonly Step[]): LaneSum[] {
  const arms = new Map<string, { detectionNs: number[]; buildNs: number[]; cappedCount: number; lastMs: number }>();
  forEachVisit(steps, (arm, { detectionTimeNs, buildTimeNs, flags }, timeMs) => {
    if (!arms.has(arm)) arms.set(arm, { detectionNs: [], buildNs: [], cappedCount: 0, lastMs: 0 });
    const own = arms.get(arm)!;
    own.detectionNs.push(Number(detectionTimeNs));
    own.buildNs.push(Number(buildTimeNs));
    own.cappedCount += flags & ShadowFlag.CAPPED ? 1 : 0;
    own.lastMs = timeMs;
  });
  return [...arms].map(([arm, { detectionNs, buildNs, cappedCount, lastMs }]) => ({
    arm, visitCount: detectionNs.length, cappedCount, medianNs: medianOf(detectionNs), lastNs: detectionNs.at(-1)!, buildNs: medianOf(buildNs), lastMs,
  }));
}

/** Returns whether the decision commanded a switch and no later step did. */
export const isLastSwitch = (decision: Step, steps: readonly Step[]) => isSwitch(decision) && (steps.findLast(isSwitch)?.decisionId ?? 0) <= decision.decisionId;

/** Returns the step in which the game executed the switch that a decision commanded. */
export const executionOf = (decision: Step, steps: readonly Step[]): Step | undefined =>
  (isSwitch(decision) ? steps.find(({ kind, timeMs }) => kind === AuditKind.SWITCH && timeMs >= decision.timeMs) : undefined);

export const stepQuery = ({ decisionId, timeMs }: Pick<Step, 'decisionId' | 'timeMs'>): { decision: string } | { at: string } =>
  (decisionId > 0 ? { decision: String(decisionId) } : { at: String(Math.round(timeMs)) });

/** Returns the decision that explains the active arm: the latest switch to this arm, or the last decision if there is no such switch. */
export function decisiveStep(steps: readonly Step[]): Step | undefined {
  const decisions = steps.filter(({ told }) => told);
  const last = decisions.at(-1);
  const active = last?.activeArm;
  return decisions.findLast((step) => isSwitch(step) && step.told?.candidate === active) ?? last;
}
