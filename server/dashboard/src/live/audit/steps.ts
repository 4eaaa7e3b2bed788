// The life of a session in steps: the rows of its audit log, then what the daemon tells live.
import { DecisionOutcome, type DecisionEvent, type FrameMeasurements } from '../../gen/sweepstake/v1/posteriors_pb';
import { SwitchReason } from '../../gen/sweepstake/v1/telemetry_pb';
import { bucketsOf, type Percentiles, percentiles } from '../numbers/histogram';
import { type Told, toldOfEvent, toldOfRow } from './explain';
import type { PlacedRow } from './log';
import { type AuditRow, objectCountOf, once, type Setup, unixMsOf, type Visit, visitsOf, type WindowMeans, windowOf } from './rows';

export interface Step {
  timeMs: number; // by the daemon's clock
  kind: string; // of the audit log
  activeArm: string; // the arm that ran before it or, if the step is a switch, after it; '': not said
  decisionId: number; // 0: no decision
  told?: Told; // of decisions
  placed?: PlacedRow; // if it is of the log
  event?: DecisionEvent; // if it was told live
}

const DECISION_KINDS = ['tick', 'bail-out'];
const hasDecision = (row: AuditRow) => DECISION_KINDS.includes(row.text('kind')) && row.text('decision_id') !== '';

/** Returns nothing for a row without a time. */
export function stepOfRow(placed: PlacedRow): Step | undefined {
  const { row, setup } = placed;
  const timeNs = row.number('time_ns');
  if (!setup || timeNs === undefined) return undefined;
  const kind = row.text('kind');
  const activeArm = kind === 'setup' ? setup.activeArm : row.text('active_arm') || (kind === 'order' ? '' : row.text('arm'));
  const step = { timeMs: unixMsOf(setup, timeNs), kind, activeArm, decisionId: row.number('decision_id') ?? 0, placed };
  return hasDecision(row) ? { ...step, told: toldOfRow(row, setup) } : step;
}

export function stepOfEvent(event: DecisionEvent, timeMs: number, rewardVersion: number): Step {
  const kind = event.reason === SwitchReason.BAIL_OUT ? 'bail-out' : 'tick';
  return { timeMs, kind, activeArm: event.activeArm, decisionId: Number(event.decisionId), told: toldOfEvent(event, rewardVersion), event };
}

/** Returns the steps of the log, with what was told of them live, and then those that the log did not have yet. */
export function mergedSteps(logged: readonly Step[], events: readonly DecisionEvent[], rewardVersion: number): Step[] {
  const byId = new Map(events.map((event): [number, DecisionEvent] => [Number(event.decisionId), event]));
  const lastId = logged.reduce((most, { decisionId }) => Math.max(most, decisionId), 0);
  let lastMs = logged.at(-1)?.timeMs ?? 0;
  const known = logged.map((step) => {
    const event = step.decisionId > 0 ? byId.get(step.decisionId) : undefined;
    return event ? { ...step, event } : step;
  });
  const later = events.filter(({ decisionId }) => Number(decisionId) > lastId).map((event) => {
    lastMs = Math.max(lastMs, Number(event.unixMs)); // the daemon's clock may be set, and times ascend
    return stepOfEvent(event, lastMs, rewardVersion);
  });
  return [...known, ...later];
}

export interface Measured {
  timeMs: number;
  frameMs: Percentiles | undefined;
  detectionMs: Percentiles | undefined;
  nativeBytes: Percentiles | undefined;
  window: WindowMeans | undefined;
  objectCount: number | undefined;
}

const inMs = (values: Percentiles | undefined): Percentiles | undefined =>
  values && [values[0] / 1e6, values[1] / 1e6, values[2] / 1e6];

const percentilesOf = once(({ frameTimeNs, detectionTimeNs, nativeBytes }: FrameMeasurements) => ({
  frameMs: inMs(frameTimeNs && percentiles(bucketsOf(frameTimeNs))),
  detectionMs: inMs(detectionTimeNs && percentiles(bucketsOf(detectionTimeNs))),
  nativeBytes: nativeBytes && percentiles(bucketsOf(nativeBytes)),
}));
const UNKNOWN = { frameMs: undefined, detectionMs: undefined, nativeBytes: undefined };

/** Returns what frames cost, by each step that says something of it. */
export function measuredOf(steps: readonly Step[]): Measured[] {
  return steps.filter(({ kind, placed, event }) => event?.measurements || (placed && kind === 'tick')).map(({ timeMs, placed, event }) => ({
    timeMs,
    ...(event?.measurements ? percentilesOf(event.measurements) : UNKNOWN),
    window: placed && windowOf(placed.row),
    objectCount: placed && objectCountOf(placed.row),
  }));
}

/** Calls `tell` with each visit of the shadow lane that the log has, oldest first. */
export function forEachVisit(steps: readonly Step[], tell: (arm: string, visit: Visit, timeMs: number) => void): void {
  for (const { timeMs, placed } of steps) {
    if (placed) for (const visit of visitsOf(placed.row)) tell(placed.setup?.arms[visit.arm] ?? `arm ${visit.arm}`, visit, timeMs);
  }
}

/** Returns the arms in the session's order, as far as they are known. */
export function armsOf(steps: readonly Step[]): string[] {
  const setup: Setup | undefined = steps.filter(({ placed }) => placed?.setup).at(-1)?.placed?.setup;
  if (setup) return setup.arms;
  const told = steps.filter(({ event }) => event && event.arms.length > 0).at(-1)?.event?.arms;
  return told ?? [...new Set(steps.map(({ activeArm }) => activeArm).filter(Boolean))];
}

export const isSwitch = ({ told }: Step) => told?.outcome === DecisionOutcome.SWITCHED;
