import { create, fromJsonText, toJsonText } from '../transport/messages';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { AuditKind, AuditRowSchema, ListDecisionsRequestSchema, ListDecisionsResponseSchema } from '../../gen/sweepstake/v1/audit_pb';
import { entriesOf, msOf, type PlacedRow, readRow, readRows, rowId, unixMsOf } from './log';
import { rows, setup } from './log.test.sample';
import { readSteps, windowOf } from './steps';

afterEach(() => vi.unstubAllGlobals());

/** A daemon whose log has the rows 1 to `count`. It returns at most `atOnce` rows in a call. Returns the requests that it received. */
function answerWith(count: number, atOnce: number) {
  const requests: string[] = [];
  vi.stubGlobal('fetch', (_url: string, { body }: { body: string }) => {
    requests.push(body);
    const { pageSize, olderThan, newerThan, row } = fromJsonText(ListDecisionsRequestSchema, body);
    const all = Array.from({ length: count }, (_, i) => count - i);
    const matching = all.filter((each) => (!olderThan || each < Number(olderThan)) && (!newerThan || each > Number(newerThan)) && (row === 0n || BigInt(each) === row));
    const size = Math.min(pageSize || 100, atOnce);
    const page = newerThan ? matching.slice(-size) : matching.slice(0, size);
    const response = create(ListDecisionsResponseSchema, {
      rows: page.map((each) => ({ session: 'a.b', segment: 1, row: BigInt(each), kind: AuditKind.TICK, timeNs: BigInt(each) * 1_000_000n })),
      setups: [{ sessionId: 'a.b', segment: 1, setup: { unixStartMs: 1000n, arms: ['SAP'] } }],
      olderToken: String(page.at(-1) ?? olderThan), newerToken: String(page[0] ?? newerThan), hasMore: page.length < matching.length,
    });
    return Promise.resolve(new Response(toJsonText(ListDecisionsResponseSchema, response)));
  });
  return requests;
}
const numbers = (part: readonly PlacedRow[]) => part.map(({ row }) => Number(row.row));
const down = (from: number, to: number) => Array.from({ length: from - to + 1 }, (_, i) => from - i);

describe('reading rows', () => {
  it('goes on until there are enough, newest first', async () => {
    const requests = answerWith(1000, 30);
    const part = await readRows({ sessionId: 'a.b' }, 70);
    expect(numbers(part.rows)).toEqual(down(1000, 931));
    expect(part).toMatchObject({ olderToken: '931', newerToken: '1000', hasMore: true });
    expect(part.rows[69]!.setup!.arms).toEqual(['SAP']);
    expect(requests).toHaveLength(3);
    const older = await readRows({ sessionId: 'a.b' }, 2000, undefined, { olderThan: part.olderToken });
    expect(numbers(older.rows)).toEqual(down(930, 1));
    expect(older).toMatchObject({ olderToken: '1', newerToken: '930', hasMore: false });
  });

  it('goes on after a place, and keeps the newest first', async () => {
    answerWith(100, 8);
    const part = await readRows({}, 500, undefined, { newerThan: '80' });
    expect(numbers(part.rows)).toEqual(down(100, 81));
    expect(part).toMatchObject({ newerToken: '100', hasMore: false });
    expect((await readRows({}, 500, undefined, { newerThan: '100' }))).toMatchObject({ rows: [], newerToken: '100' });
  });

  it('finds one row by its id, in one call', async () => {
    const requests = answerWith(1000, 100);
    expect((await readRow('a.b.1.7'))?.row.row).toBe(7n);
    expect(requests).toEqual(['{"filter":{"sessionId":"a.b"},"segment":1,"row":"7"}']);
    expect(await readRow('a.b.1.1001')).toBeNull();
    expect(await readRow('nonsense')).toBeNull();
  });

  it('reads the steps of a range of time, oldest first', async () => {
    const requests = answerWith(5, 100);
    const steps = await readSteps('a.b', 1000.4, 1004.2);
    expect(steps.map(({ timeMs }) => timeMs)).toEqual([1001, 1002, 1003, 1004, 1005]);
    expect(requests[0]).toContain('"unixFromMs":"1000","unixUntilMs":"1005"');
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
