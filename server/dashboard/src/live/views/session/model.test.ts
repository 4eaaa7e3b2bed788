import { create } from '../../transport/messages';
import { describe, expect, it } from 'vitest';
import { AuditKind } from '../../../gen/sweepstake/v1/audit_pb';
import { rows, setup } from '../../audit/log.test.sample';
import { armsOf, forEachVisit, isSwitch, mergedSteps, type Step, stepOfRow, windowOf } from '../../audit/steps';
import { DecisionEventSchema, DecisionOutcome } from '../../../gen/sweepstake/v1/posteriors_pb';
import { middleOf } from '../../numbers/histogram';
import { beliefRows, costColumns, decisiveStep, executionOf, isLastSwitch, laneSums, priorAndPosterior, stepsIn, switchMoments } from './model';

const steps = rows.map((row) => stepOfRow({ row, setup })).filter((step): step is Step => step !== undefined);
const arms = armsOf(steps);

describe('the steps of a log', () => {
  it('are one per row, with the row’s decision', () => {
    expect(steps).toHaveLength(rows.length);
    expect(steps[0]).toMatchObject({ kind: AuditKind.SETUP, activeArm: setup.arms[setup.activeArm], decisionId: 0 });
    const ticks = steps.filter(({ kind }) => kind === AuditKind.TICK);
    expect(ticks.map(({ decisionId }) => decisionId)).toEqual(ticks.map((_, i) => i + 1));
    expect(ticks.every(({ told }) => told !== undefined)).toBe(true);
    expect(ticks[0]!.activeArm).toBe(setup.arms[setup.activeArm]);
    expect(arms).toEqual(setup.arms);
  });

  it('continue with decisions received live, each decision once', () => {
    const last = steps.at(-1)!.decisionId;
    const endMs = Math.ceil(steps.at(-1)!.timeMs);
    const events = [endMs, endMs + 250, endMs + 100].map((unixMs, i) =>
      create(DecisionEventSchema, { decisionId: BigInt(last + i), activeArm: 'SAP', unixMs: BigInt(unixMs) }));
    const all = mergedSteps(steps, events, 3);
    expect(all).toHaveLength(steps.length + 2);
    expect(all[steps.length - 1]!.event).toBe(events[0]);
    expect(all.slice(-2).map(({ decisionId, activeArm }) => [decisionId, activeArm])).toEqual([[last + 1, 'SAP'], [last + 2, 'SAP']]);
    expect(all.slice(-2).map(({ timeMs }) => timeMs), 'times of the daemon’s clock, ascending even if the clock is set back').toEqual([endMs + 250, endMs + 250]);
  });
});

describe('the steps in a range of time', () => {
  const at = (...times: number[]) => times.map((timeMs): Step => ({ timeMs, kind: AuditKind.TICK, activeArm: '', decisionId: 0 }));
  const all = at(1, 2, 3, 4, 5);
  const timesIn = (fromMs: number, toMs: number) => stepsIn({ fromMs, toMs }, all).map(({ timeMs }) => timeMs);

  it('have one more on each side, so that lines reach the ends', () => {
    expect(timesIn(3, 3)).toEqual([2, 3, 4]);
    expect(timesIn(2.5, 4.5)).toEqual([2, 3, 4, 5]);
    expect(timesIn(3.2, 3.4), 'between two steps').toEqual([3, 4]);
    expect(timesIn(0, 9)).toEqual([1, 2, 3, 4, 5]);
    expect(timesIn(-5, 0), 'before the first').toEqual([1]);
    expect(timesIn(6, 7), 'after the last').toEqual([]);
    expect(stepsIn(undefined, all)).toBe(all);
  });
});

describe('costs', () => {
  it('are in columns: window means from the log, percentiles from live decisions', () => {
    const measurements = { frameTimeNs: { bucketSteps: [190], counts: [100] }, detectionTimeNs: { bucketSteps: [160], counts: [100] }, nativeBytes: { bucketSteps: [100], counts: [100] } };
    const all = mergedSteps(steps, [create(DecisionEventSchema, { decisionId: 10_000n, activeArm: 'SAP', measurements })], 3);
    const columns = costColumns(all);
    expect(columns.frame.map((column) => column.at(-1))).toEqual([null, middleOf(190) / 1e6, middleOf(190) / 1e6, middleOf(190) / 1e6]);
    expect(columns.frame[0]!.filter((value) => value !== null).length).toBeGreaterThan(20);
    expect(columns.checks).toContain(rows.map(windowOf).find((window) => window !== undefined)!.checkCount);
    expect(columns.objects).toContain(300);
    const told = columns.objects.findIndex((value) => value !== null);
    expect(columns.objects.slice(told).every((value) => value !== null), 'a count holds until the next').toBe(true);
    expect(new Set(columns.frame.map(({ length }) => length))).toEqual(new Set([columns.timesMs.length]));
  });

  it('in the shadow lane are summed by arm', () => {
    const sums = laneSums(steps);
    let visitCount = 0;
    forEachVisit(steps, () => ++visitCount);
    expect(sums.map(({ arm }) => arm).sort()).toEqual([...arms].sort());
    expect(sums.reduce((sum, lane) => sum + lane.visitCount, 0)).toBe(visitCount);
    for (const { medianNs, lastNs } of sums) expect(Math.min(medianNs, lastNs)).toBeGreaterThan(0);
  });
});

describe('beliefs', () => {
  it('are those of the log, with probabilities that sum to 1', () => {
    const beliefs = beliefRows(steps, arms.length);
    expect(beliefs.length).toBeGreaterThan(20);
    for (const { best } of beliefs) expect(best.reduce((sum: number, p) => sum + (p ?? 0), 0)).toBeCloseTo(1, 6);
    const last = priorAndPosterior(steps, arms);
    expect(last.map(({ arm }) => arm)).toEqual(arms);
    expect(last.find(({ arm }) => arm === 'KDTree')!.measured).toBe('live');
    expect(last.filter(({ measured }) => measured === 'lane').length).toBeGreaterThan(2);
  });

  it('end with the last posterior of the log, after any number of live decisions', () => {
    const logged = steps.at(-1)!;
    const events = Array.from({ length: 2000 }, (_, i) => create(DecisionEventSchema, { decisionId: BigInt(logged.decisionId + 1 + i), activeArm: 'SAP',
      unixMs: BigInt(Math.ceil(logged.timeMs) + 1 + i), bestProbability: arms.map((__, arm) => (i + arm) % 2) }));
    const rowsOfAll = beliefRows(mergedSteps(steps, events, 3), arms.length);
    expect(rowsOfAll.length).toBeLessThan(700);
    expect(rowsOfAll.findLast(({ beliefs }) => beliefs.some(Boolean))!.timeMs).toBe(logged.timeMs);
  });
});

describe('"Why this algorithm?"', () => {
  it('opens the switch to the active arm, or the last decision', () => {
    const last = steps.at(-1)!;
    const event = (later: number, activeArm: string, candidate: string, outcome: DecisionOutcome) => create(DecisionEventSchema,
      { decisionId: BigInt(last.decisionId + later), unixMs: BigInt(Math.ceil(last.timeMs) + later), activeArm, candidateArm: candidate, outcome });
    const toSap = event(1, last.activeArm, 'SAP', DecisionOutcome.SWITCHED);
    expect(decisiveStep(mergedSteps(steps, [toSap, event(2, 'SAP', 'SAP', DecisionOutcome.KEPT)], 3))!.event).toBe(toSap);
    const kept = event(2, 'Grid', 'Grid', DecisionOutcome.KEPT); // there is no switch to Grid
    expect(decisiveStep(mergedSteps(steps, [toSap, kept], 3))!.event).toBe(kept);
    expect(decisiveStep([])).toBeUndefined();
  });

  it('finds the switch that the game executed after a decision, and the last switch', () => {
    const commands = steps.filter(isSwitch);
    const done = steps.find(({ kind }) => kind === AuditKind.SWITCH);
    expect(commands.length).toBeGreaterThan(1);
    expect(executionOf(commands[0]!, steps)).toBe(done);
    expect(executionOf(commands[0]!, []), 'not in the view').toBeUndefined();
    const kept = steps.find((step) => step.told && !isSwitch(step))!;
    expect(executionOf(kept, steps)).toBeUndefined();
    expect(commands.filter((step) => isLastSwitch(step, steps))).toEqual([commands.at(-1)]);
    expect(isLastSwitch(commands[0]!, []), 'read from the log, older than the steps of the view').toBe(true);
    expect(isLastSwitch(kept, [])).toBe(false);
  });

  it('marks each change of the active arm', () => {
    const moments = switchMoments(steps, arms);
    expect(moments.length).toBeGreaterThan(0);
    expect(moments[0]!.timeMs).toBe(steps.find(({ activeArm }) => activeArm !== setup.arms[setup.activeArm])!.timeMs);
  });
});
