import { describe, expect, it } from 'vitest';
import { rows, setup } from './sample_log';
import { type AuditRow, objectCountOf, RowReader, setupOf, setupPairs, unixMsOf, visitsOf, windowOf } from './rows';

const ticks = rows.filter((row) => row.text('kind') === 'tick');

const SAMPLE_FRAMES = '0:0:1:1:45359984:20000000:25355544:1081:1081:25355544:10363181:9991770.491909413:1081:17:9616.543795872:0:60190080:48482850:13440';
const SAMPLE_VISIT = '172:10579:30790:55680:13440:0:300:5';

const rowWith = (columns: string, cells: string): AuditRow => {
  const own = new RowReader();
  own.header(columns);
  return own.row(cells)!;
};

describe('an audit log', () => {
  it('begins with a setup that names the arms and intervals', () => {
    expect(rows[0]!.text('kind')).toBe('setup');
    expect(setup).toMatchObject({
      project: 'logs', scene: 'adaptive', policy: 'adaptive', arms: ['BruteForce', 'Grid', 'SAP', 'AxisSweep', 'DBVT', 'Tracy', 'KDTree'],
      decisionIntervalMs: 20, cooldownMs: 400, settlingMs: 20, bailOutMs: 5000, mode: 'ai', priors: [],
    });
    expect(setup.activeArm).toBe(setup.arms[Number(/;active_arm=(\d)/.exec(rows[0]!.text('setup'))![1])]);
  });

  it('has times since its start by the wall clock', () => {
    const times = ticks.map((row) => unixMsOf(setup, row.number('time_ns')!));
    const nsSinceStart = BigInt(ticks[0]!.text('time_ns')) - BigInt(rows[0]!.text('time_ns'));
    expect(times[0]! - setup.unixStartMs).toBeCloseTo(Number(nsSinceStart) / 1e6, 2);
    expect(times[0]! - setup.unixStartMs).toBeGreaterThanOrEqual(setup.decisionIntervalMs);
    expect(times.every((ms, i) => i === 0 || ms > times[i - 1]!)).toBe(true);
  });

  it('has lists with an item per arm', () => {
    for (const column of ['alpha', 'beta', 'best_probability'] as const) expect(ticks[0]!.numbers(column)).toHaveLength(7);
    const sum = ticks[0]!.numbers('best_probability').reduce((total, p) => total + p, 0);
    expect(sum).toBeCloseTo(1, 9);
    expect(rows[0]!.numbers('alpha')).toEqual([]);
  });

  it('tells what the frames of a window cost', () => {
    // 1081 frames in 25355544 ns, of which detection took 10363181; 60190080 checks.
    const window = windowOf(rowWith('runs', `1 ${SAMPLE_FRAMES}`))!;
    expect(window.frameCount).toBe(1081);
    expect(window.frameMs).toBeCloseTo(25.355544 / 1081, 9);
    expect(window.detectionMs).toBeCloseTo(10.363181 / 1081, 9);
    expect(window.checkCount).toBeCloseTo(55_680, 6);
    expect(window.nativeBytes).toBe(13_440);
    expect(windowOf(rowWith('runs', '1 0:0:1:1:19273916:20000000:0:0:0:0:0:0:0:0:0:0:0:0:0'))).toBeUndefined(); // all its frames settled
    const windows = ticks.map(windowOf).filter((each) => each !== undefined);
    expect(windows.length).toBeGreaterThan(20);
    for (const { frameMs, detectionMs, checkCount, nativeBytes } of windows) {
      expect(frameMs).toBeGreaterThan(detectionMs);
      expect(checkCount).toBeGreaterThan(300); // of 300 objects
      expect(nativeBytes % 8).toBe(0);
      expect(nativeBytes).toBeLessThan(1 << 20);
    }
  });

  it('tells what the lane measured, and how many objects there were', () => {
    expect(visitsOf(rowWith('shadow', `${SAMPLE_VISIT}:1 ${SAMPLE_VISIT}:2`))).toEqual([
      { arm: 0, detectionNs: 10_579, buildNs: 30_790, wasActive: true, wasCapped: false },
      { arm: 0, detectionNs: 10_579, buildNs: 30_790, wasActive: false, wasCapped: true },
    ]);
    const visits = ticks.flatMap(visitsOf);
    expect(new Set(visits.map(({ arm }) => arm)).size).toBe(setup.arms.length);
    for (const { detectionNs, buildNs } of visits) expect(Math.min(detectionNs, buildNs)).toBeGreaterThan(0);
    expect(objectCountOf(ticks[0]!)).toBe(300);
    expect(objectCountOf(rows[0]!)).toBeUndefined();
  });

  it('names its rows', () => expect(ticks[0]!.id).toBe(`${ticks[0]!.text('session')}.1.2`));
});

describe('what people have named', () => {
  const rowOf = (...cells: string[]): AuditRow =>
    rowWith('session,segment,row,kind,time_ns,setup', cells.map((cell) => `"${cell.replaceAll('"', '""')}"`).join(','));

  it('is read with its backslashes, semicolons and commas', () => {
    const row = rowOf('id', '1', '1', 'setup', '5', String.raw`project=a\;b=c\\;scene=x\,y;arms=one\,1,two\;2;cooldown_ns=1e6;priors=2.5:3,1:1`);
    expect(setupOf(row)).toMatchObject({ project: String.raw`a;b=c\ `.trim(), scene: 'x,y', arms: ['one,1', 'two;2'], cooldownMs: 1, priors: [{ alpha: 2.5, beta: 3 }, { alpha: 1, beta: 1 }] });
    expect(setupPairs('a=1;b=x=y')).toEqual(new Map([['a', '1'], ['b', 'x=y']]));
  });

  it('cannot break a row: one with wrong quotes is counted and left out', () => {
    const own = new RowReader();
    own.header('a,b');
    expect(own.row('1,"open')).toBeUndefined();
    expect(own.unreadableCount).toBe(1);
    expect(own.row('"two\nlines",2')!.entries()).toEqual([['a', 'two\nlines'], ['b', '2']]);
  });

  it('of a newer file has columns that the page passes over, of an older one lacks some', () => {
    const row = rowWith('session,segment,row,kind,new_column', 'id,1,2,tick,9');
    expect([row.text('kind'), row.text('gain'), row.number('gain')]).toEqual(['tick', '', undefined]);
  });
});
