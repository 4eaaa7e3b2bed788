// A session's steps: the rows of its audit log, then the decisions of the live stream.
import { AuditKind, type AuditRow, type AuditSetup } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome, type DecisionEvent, type FrameMeasurements } from '../../gen/sweepstake/v1/posteriors_pb';
import { type ShadowSample, SwitchReason } from '../../gen/sweepstake/v1/telemetry_pb';
import { type LogHistogram, percentiles } from '../numbers/histogram';
import { type Told, toldOfEvent, toldOfRow } from './explain';
import { once } from '../state/once';
import { NS_PER_MS } from '../numbers/log_cost';
import { type LogPart, type PlacedRow, readRows, unixMsOf } from './log';

/** The number of latest steps that a view keeps, about three hours at the paper's decision interval. */
export const MAX_STEPS = 5000;

export interface Step {
  timeMs: number; // by the daemon's clock
  kind: AuditKind;
  activeArm: string; // the arm that ran before the step or, if the step is a switch, after it; '': unknown
  decisionId: number; // 0: no decision
  told?: Told; // present for decisions
  placed?: PlacedRow; // present for steps from the log
  event?: DecisionEvent; // present for steps from the live stream
}

/** Returns the step of a row; undefined for a row without a time or without the setup of its segment. */
export function stepOfRow(placed: PlacedRow): Step | undefined {
  const { row, setup } = placed;
  const { kind, timeNs, decision } = row;
  if (!setup || timeNs === undefined) return undefined;
  const activeArm = kind === AuditKind.SETUP ? setup.arms[setup.activeArm] ?? '' : decision?.activeArm || (kind === AuditKind.ORDER ? '' : row.arm);
  const step = { timeMs: unixMsOf(setup, timeNs), kind, activeArm, decisionId: Number(decision?.id ?? 0), placed };
  return decision ? { ...step, told: toldOfRow(row, setup) } : step;
}

export const stepsOf = ({ rows }: LogPart): Step[] => rows.map(stepOfRow).filter((step) => step !== undefined).reverse();

/** Reads a session's steps from one time to another, oldest first, but at most the latest MAX_STEPS. Throws ApiError. */
export const readSteps = async (sessionId: string, fromMs: number, untilMs: number, cancel?: AbortSignal): Promise<Step[]> =>
  stepsOf(await readRows({ sessionId, unixFromMs: BigInt(Math.floor(fromMs)), unixUntilMs: BigInt(Math.ceil(untilMs)) }, MAX_STEPS, cancel));

export function stepOfEvent(event: DecisionEvent, timeMs: number, rewardVersion: number): Step {
  const kind = event.reason === SwitchReason.BAIL_OUT ? AuditKind.BAIL_OUT : AuditKind.TICK;
  return { timeMs, kind, activeArm: event.activeArm, decisionId: Number(event.decisionId), told: toldOfEvent(event, rewardVersion), event };
}

/** Returns the steps of the log with their live events, then the live decisions that the log does not contain yet. */
export function mergedSteps(logged: readonly Step[], events: readonly DecisionEvent[], rewardVersion: number): Step[] {
  const byId = new Map(events.map((event): [number, DecisionEvent] => [Number(event.decisionId), event]));
  const lastId = logged.reduce((most, { decisionId }) => Math.max(most, decisionId), 0);
  let lastMs = logged.at(-1)?.timeMs ?? 0;
  const known = logged.map((step) => {
    const event = step.decisionId > 0 ? byId.get(step.decisionId) : undefined;
    return event ? { ...step, event } : step;
  });
  const later = events.filter(({ decisionId }) => Number(decisionId) > lastId).map((event) => {
    lastMs = Math.max(lastMs, Number(event.unixMs)); // keeps times ascending even if the daemon's clock was set back
    return stepOfEvent(event, lastMs, rewardVersion);
  });
  return [...known, ...later];
}

/** Returns mean costs and the peak of memory in the row's decision window; undefined without frames. Without frames of a known regime, these
 * are the new frames, which the decision uses unless their regime is in doubt (engine_client/decider/session/decision_session.cc). */
export const windowOf = once((row: AuditRow) => {
  const active = row.runs?.active;
  const window = active?.window?.frameCount ? active.window : active?.newFrames;
  const frameCount = Number(window?.frameCount ?? 0);
  if (!window || frameCount === 0) return undefined;
  return {
    frameMs: window.timeNs / frameCount / NS_PER_MS,
    // An ordinary frame does not rebuild.
    detectionMs: window.ordinaryFrameCount > 0 ? window.ordinaryDetectionNs / Number(window.ordinaryFrameCount) / NS_PER_MS : Number.NaN,
    checkCount: window.checkCount / frameCount,
    nativeBytes: Number(window.peakBytes),
  };
});

const inMs = (histogram: LogHistogram | undefined) => percentiles(histogram)?.map((ns) => ns / NS_PER_MS);

/** Returns p50, p95 and p99 of each cost of the frames; undefined for a cost without measurements. */
export const percentilesOf = once(({ frameTimeNs, detectionTimeNs, nativeBytes }: FrameMeasurements) => ({
  frameMs: inMs(frameTimeNs),
  detectionMs: inMs(detectionTimeNs),
  nativeBytes: percentiles(nativeBytes),
}));

/** Calls `visit` with each visit of the shadow lane in the log, oldest first. */
export function forEachVisit(steps: readonly Step[], visit: (arm: string, sample: ShadowSample, timeMs: number) => void): void {
  for (const { timeMs, placed } of steps) {
    for (const sample of placed?.row.shadow ?? []) visit(placed?.setup?.arms[sample.arm] ?? `algorithm ${sample.arm}`, sample, timeMs);
  }
}

/** Returns the session's arms in the order of its log; without a log, the arms that the steps contain. */
export function armsOf(steps: readonly Step[]): string[] {
  const setup: AuditSetup | undefined = steps.findLast(({ placed }) => placed?.setup)?.placed?.setup;
  if (setup) return setup.arms;
  const told = steps.findLast(({ event }) => event && event.arms.length > 0)?.event?.arms;
  return told ?? [...new Set(steps.map(({ activeArm }) => activeArm).filter(Boolean))];
}

export const isSwitch = ({ told }: Step) => told?.outcome === DecisionOutcome.SWITCHED;
