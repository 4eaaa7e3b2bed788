import { create } from '../transport/messages';
import { describe, expect, it } from 'vitest';
import { AuditKind, AuditRowSchema } from '../../gen/sweepstake/v1/audit_pb';
import { DecisionOutcome } from '../../gen/sweepstake/v1/posteriors_pb';
import { collectPage, entriesOf, findRow, msOf, PAGE_ROWS, type PlacedRow, rowId, unixMsOf } from './log';
import { rows, setup } from './sample_log';
import { windowOf } from './steps';

async function* log(count: number): AsyncGenerator<PlacedRow> {
  for (let i = 1; i <= count; ++i) {
    yield { row: create(AuditRowSchema, { session: 'id', segment: 1, row: BigInt(i), kind: i % 10 === 0 ? AuditKind.SWITCH : AuditKind.TICK,
      decision: { activeArm: i % 2 ? 'SAP' : 'DBVT', candidate: 'Grid', outcome: DecisionOutcome.KEPT } }) };
  }
}
const ALL = { kind: '', outcome: '', arm: '' };
const numbers = (page: readonly PlacedRow[]) => page.map(({ row }) => Number(row.row));
const pageOf = (count: number, filter = ALL, page = 0) => collectPage(log(count), filter, page, () => undefined);

describe('pages of a log', () => {
  it('have the newest rows first, each row once', async () => {
    const pages = await Promise.all([0, 1, 2, 3].map((page) => pageOf(250, ALL, page)));
    expect(pages.flatMap((page) => numbers(page.rows))).toEqual(Array.from({ length: 250 }, (_, i) => 250 - i));
    expect(pages.map((page) => page.rows.length)).toEqual([PAGE_ROWS, PAGE_ROWS, 50, 0]);
    expect(pages[3]).toMatchObject({ matchCount: 250, rowCount: 250 });
    expect(numbers((await pageOf(5000, ALL, 7)).rows)[0], 'a page of a long log').toBe(4300);
  });

  it('contain the rows that match', async () => {
    const { rows: switches, matchCount } = await pageOf(1000, { ...ALL, kind: 'SWITCH' });
    expect(matchCount).toBe(100);
    expect(numbers(switches).slice(0, 3)).toEqual([1000, 990, 980]);
    expect((await pageOf(100, { ...ALL, arm: 'SAP' })).matchCount).toBe(50);
    expect((await pageOf(100, { ...ALL, arm: 'Grid', outcome: 'SWITCHED' })).matchCount).toBe(0);
  });

  it('are not needed for one row, which is found without reading on', async () => {
    const all = log(1000);
    expect((await findRow(all, 'id.1.7'))?.row.row).toBe(7n);
    expect(await findRow(log(10), 'id.1.11')).toBeNull();
  });
});

describe('the rows of a log', () => {
  const ticks = rows.filter(({ kind }) => kind === AuditKind.TICK);

  it('have ascending times from the start of the segment', () => {
    const times = ticks.map(({ timeNs }) => unixMsOf(setup, timeNs!));
    expect(times[0]! - Number(setup.unixStartMs)).toBeGreaterThanOrEqual(msOf(setup.decisionIntervalNs));
    expect(times.every((ms, i) => i === 0 || ms > times[i - 1]!)).toBe(true);
  });

  it('give the mean costs of a window', () => {
    const of = (active: object) => windowOf(create(AuditRowSchema, { runs: { active } }));
    const ofWindow = (window: object) => of({ window });
    const window = ofWindow({ frameCount: 1081n, ordinaryFrameCount: 1081n, timeNs: 25_355_544, ordinaryDetectionNs: 10_363_181, checkCount: 60_190_080, peakBytes: 13_440n })!;
    expect(window).toEqual({ frameMs: expect.closeTo(25.355544 / 1081, 9), detectionMs: expect.closeTo(10.363181 / 1081, 9), checkCount: expect.closeTo(55_680, 6), nativeBytes: 13_440 });
    expect(ofWindow({})).toBeUndefined();
    const newFrames = { frameCount: 2n, timeNs: 30e6 };
    expect(of({ window: {}, newFrames })!.frameMs, 'without frames of a known regime, the new ones count').toBeCloseTo(15, 9);
    expect(of({ window: { frameCount: 1n, timeNs: 8e6 }, newFrames })!.frameMs).toBeCloseTo(8, 9);
  });

  it('are listed with the paths of their fields', () => {
    const entries = new Map(entriesOf(ticks[0]!));
    expect(entries.get('row')).toBe('2');
    expect(entries.get('decision.posteriors.6.beta')).toBe(String(ticks[0]!.decision!.posteriors[6]!.beta));
    expect(entries.get('decision.bestProbability')!.split(' ')).toHaveLength(7);
    expect(rowId(ticks[0]!)).toBe(`${ticks[0]!.session}.1.2`);
  });
});
