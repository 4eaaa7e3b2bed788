import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { AuditKind, AuditRowSchema } from '../../gen/sweepstake/v1/audit_pb';
import { entriesOf, msOf, rowId, unixMsOf, windowOf } from './rows';
import { rows, setup } from './sample_log';

const ticks = rows.filter(({ kind }) => kind === AuditKind.TICK);

describe('an audit log', () => {
  it('begins with a setup that names the arms and intervals', () => {
    expect(rows[0]!.kind).toBe(AuditKind.SETUP);
    expect(setup).toMatchObject({
      project: 'logs', scene: 'adaptive', policy: 'adaptive', arms: ['BruteForce', 'Grid', 'SAP', 'AxisSweep', 'DBVT', 'Tracy', 'KDTree'], priors: [],
    });
    expect([setup.decisionIntervalNs, setup.cooldownNs, setup.settlingNs, setup.bailOutNs].map(msOf)).toEqual([20, 400, 20, 5000]);
  });

  it('has ascending times from the start of the segment', () => {
    const times = ticks.map(({ timeNs }) => unixMsOf(setup, timeNs!));
    expect(times[0]! - Number(setup.unixStartMs)).toBeGreaterThanOrEqual(msOf(setup.decisionIntervalNs));
    expect(times.every((ms, i) => i === 0 || ms > times[i - 1]!)).toBe(true);
  });

  it('gives the mean costs of a window', () => {
    const ofWindow = (window: object) => windowOf(create(AuditRowSchema, { runs: { active: { window } } }));
    const window = ofWindow({ frameCount: 1081n, ordinaryFrameCount: 1081n, timeNs: 25_355_544, ordinaryDetectionNs: 10_363_181, checkCount: 60_190_080, peakBytes: 13_440n })!;
    expect(window.frameCount).toBe(1081);
    expect(window.frameMs).toBeCloseTo(25.355544 / 1081, 9);
    expect(window.detectionMs).toBeCloseTo(10.363181 / 1081, 9);
    expect(window.checkCount).toBeCloseTo(55_680, 6);
    expect(window.nativeBytes).toBe(13_440);
    expect(ofWindow({})).toBeUndefined();
    const windows = ticks.map(windowOf).filter((each) => each !== undefined);
    expect(windows.length).toBeGreaterThan(20);
    for (const { frameMs, detectionMs } of windows) expect(frameMs).toBeGreaterThan(detectionMs);
  });

  it('lists the fields of a row with their paths', () => {
    const entries = new Map(entriesOf(ticks[0]!));
    expect(entries.get('row')).toBe('2');
    expect(entries.get('decision.posteriors.6.beta')).toBe(String(ticks[0]!.decision!.posteriors[6]!.beta));
    expect(entries.get('decision.bestProbability')!.split(' ')).toHaveLength(7);
    expect(rowId(ticks[0]!)).toBe(`${ticks[0]!.session}.1.2`);
  });
});
